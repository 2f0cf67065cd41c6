// Pictures against their records, each for itself.
#include "stimuli/verify_pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "base/digest.h"
#include "base/files.h"
#include "stimuli/origin.h"
#include "stimuli/png_file.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

class VerifyPictures : public testing::Test {
 protected:
  VerifyPictures() {
    make_folder(folder_.picture_folder());
    manifest_.tones["G0-MS-ind-ref-v0"] = {0.1, 1, 1e-7, 0.18, "background"};
    for (const std::string& key : keys_) add(key, "pictures/" + key + ".png");
  }
  void add(const std::string& key, const std::string& file) {
    LdrImage image(4, 3);
    image.values.assign(image.values.size(),
                        static_cast<std::uint8_t>(key.back() + manifest_.pictures.size()));
    save_png(image, folder_.root / file);
    manifest_.pictures[key] = {file, digest_file(folder_.root / file), digest_text("from"), {}};
  }
  fs::path file_of(const std::string& key) const { return folder_.picture_folder() / (key + ".png"); }
  std::vector<std::string> verify() const {
    std::vector<std::string> found;
    for (const Finding& finding : verify_pictures(folder_, study_, manifest_, keys_))
      found.push_back(format_finding(finding));
    return found;
  }

  const TempFolder temporary_;
  const StudyFolder folder_{temporary_.path()};
  static Study load_small() {
    Study study = load_study(fs::path(EQUILUX_SOURCE_DIR) / "protocols/pocket.json");
    study.width = 4;
    study.height = 3;
    return study;
  }

  const Study study_ = load_small();
  Manifest manifest_{study_.name, study_.digest, study_.seed, 4, 3, {}, {}};
  const std::vector<std::string> keys_{"G0-MS-ind-1k-C0-v0", "G0-MS-ind-1k-C1-v0", "G0-MS-ind-1k-C2-v0"};
};

TEST_F(VerifyPictures, FindNothingInThoseAsTheyWereMade) { EXPECT_THAT(verify(), IsEmpty()); }

TEST_F(VerifyPictures, GoOnAfterOneThatIsNotThere) {
  fs::remove(file_of(keys_[0]));
  fs::remove(file_of(keys_[2]));
  make_folder(file_of(keys_[2]));
  EXPECT_THAT(verify(), ElementsAre(keys_[0] + ": no file " + file_of(keys_[0]).string(),
                                    keys_[2] + ": no file " + file_of(keys_[2]).string()));
}

// A regular file, of which the first page cannot be read by anybody.
TEST_F(VerifyPictures, GoOnAfterOneThatFailsToBeRead) {
  fs::remove(file_of(keys_[0]));
  fs::create_symlink("/proc/self/mem", file_of(keys_[0]));
  fs::remove(file_of(keys_[2]));
  EXPECT_THAT(verify(), ElementsAre(AllOf(HasSubstr(keys_[0] + ": " + file_of(keys_[0]).string()),
                                          HasSubstr("expected a readable file, got ")),
                                    HasSubstr(keys_[2] + ": no file ")));
}

TEST_F(VerifyPictures, GoOnAfterOneThatMayNotBeRead) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read everything";
  fs::permissions(file_of(keys_[0]), fs::perms::none);
  fs::remove(file_of(keys_[2]));
  EXPECT_THAT(verify(), ElementsAre(HasSubstr("expected a readable file, got Permission denied"),
                                    HasSubstr(keys_[2] + ": no file ")));
}

TEST_F(VerifyPictures, FindAManifestThatSaysOfItsStudyWhatIsNotSo) {
  const Manifest before = manifest_;
  const auto expect = [&](const std::string& what) {
    EXPECT_THAT(verify(), Contains(AllOf(StartsWith(folder_.manifest().string() + ": "), HasSubstr(what))));
    manifest_ = before;
  };
  manifest_.seed += 1;
  expect(fmt::format("seed {}, where the study has {}", study_.seed + 1, study_.seed));
  manifest_.study_name = "mine";
  expect("of the study \"mine\", where study.json has \"pocket\"");
  manifest_.noise_target = NoiseTarget{1, 2, 3};
  expect("another noise target than the study's");
  manifest_.width = 5;
  expect("pictures of 5 x 3 pixels, where the study has 4 x 3");
}

// As `tonemap` leaves them; then a layer is made again, or a record is changed by hand.
TEST_F(VerifyPictures, FindThoseThatAreNotMadeFromTheLayersByTheirToneCurve) {
  Layers layers{study_.name, study_.digest, study_.seed, {}};
  const Family family = parse_family("G0-MS-ind-ref-v0", "test");
  std::vector<std::string> names = keys_;
  for (const char* content : kFamilyContents) names.push_back(layer_name(family, content));
  for (const std::string& name : names)
    layers.by_name[name] = {"layers/" + name + ".exr", digest_text(name), digest_text("recipe")};
  save_layers(layers, folder_.layers());
  for (const std::string& key : keys_)
    manifest_.pictures.at(key).made_from =
        digest_picture(layers.by_name, manifest_.tones.at("G0-MS-ind-ref-v0"), parse_condition(key, "test"));
  EXPECT_THAT(verify(), IsEmpty());
  layers.by_name.at(keys_[1]).digest = digest_text("made again");
  save_layers(layers, folder_.layers());
  EXPECT_THAT(verify(), ElementsAre(HasSubstr(keys_[1] + ": not made from the layers of layers.json")));
  manifest_.tones.at("G0-MS-ind-ref-v0").white *= 1.25;
  EXPECT_THAT(verify(), SizeIs(3)) << "another curve is that of none";
  save_text(folder_.layers(), "{");
  EXPECT_THAT(verify(), ElementsAre(StartsWith("layers: " + folder_.layers().string())));
}

// Whole, and of its digest: but it is the picture of another key, or will be overwritten as such.
TEST_F(VerifyPictures, FindARecordThatNamesAnotherFile) {
  add(keys_[0], "pictures/a.png");
  manifest_.pictures[keys_[2]] = manifest_.pictures[keys_[1]];
  EXPECT_THAT(
      verify(),
      ElementsAre(fmt::format("{0}: recorded as pictures/a.png, where pictures/{0}.png is meant", keys_[0]),
                  fmt::format("{0}: recorded as pictures/{1}.png, where pictures/{0}.png is meant", keys_[2],
                              keys_[1])));
}

}  // namespace
}  // namespace equilux
