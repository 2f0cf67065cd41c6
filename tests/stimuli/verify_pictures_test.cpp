// Pictures against their records, each for itself.
#include "stimuli/verify_pictures.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "base/digest.h"
#include "base/files.h"
#include "stimuli/png_file.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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
  const Study study_ = load_study(fs::path(EQUILUX_SOURCE_DIR) / "protocols/pocket.json");
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
