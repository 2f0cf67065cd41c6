// What a verification found stands until it was looked at again.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/set.h"
#include "stimuli/png_file.h"
#include "stimuli/verdict.h"
#include "tests/renderer/rendered_set.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

const std::string kKey = "G0-MS-ind-100-C4-v0";

class DoubtedSet : public test::RenderedSet {
 protected:
  DoubtedSet() : whole_(test::digest_products(folder_.root)) {}

  // Another picture, with the digest that the manifest has of it.
  void exchange(const std::string& key, const LdrImage& other) const {
    const fs::path path = folder_.root / "pictures" / (key + ".png");
    save_png(other, path);
    change_manifest([&](Manifest& manifest) { manifest.pictures.at(key).digest = digest_file(path); });
  }
  LdrImage load(const std::string& key) const { return load_png(folder_.root / "pictures" / (key + ".png")); }

  // What `equilux-render verify` does.
  std::vector<Finding> verify(const std::optional<fs::path>& study = {}) const {
    return renew_verdict(folder_, verify_set(folder_.root, study).findings, study.has_value());
  }
  SetSummary make(const std::string& only = "*") const {
    return make_set({study_.path(), folder_.root, only});
  }

  const std::map<std::string, std::string> whole_;
};

TEST_F(DoubtedSet, IsMendedByToneMappingOrRenderingIt) {
  const LdrImage other = load("G0-MS-ind-100-C0-v1");
  for (const bool renders : {false, true}) {
    exchange(kKey, other);
    ASSERT_FALSE(verify().empty());
    const SetSummary summary = renders ? make() : tonemap_set(folder_.root);
    EXPECT_EQ(summary.pictures_written, 1u);
    EXPECT_THAT(summary.findings, IsEmpty());
    EXPECT_EQ(test::digest_products(folder_.root), whole_) << "and no verdict is left";
  }
}

TEST_F(DoubtedSet, WithoutItsFolderOfPicturesIsWholeOnceToneMapped) {
  fs::remove_all(folder_.picture_folder());
  tonemap_set(folder_.root);
  EXPECT_EQ(test::digest_products(folder_.root), whole_);
}

// Tone mapping takes up what a run that was killed had on record in layers.pending.json alone.
TEST_F(DoubtedSet, WhoseRecordsArePendingIsWholeOnceToneMapped) {
  fs::rename(folder_.layers(), folder_.pending_layers());
  EXPECT_THAT(tonemap_set(folder_.root).findings, IsEmpty());
  EXPECT_EQ(test::digest_products(folder_.root), whole_);
  EXPECT_FALSE(fs::exists(folder_.pending_layers()));
}

// Before anything is written.
TEST_F(DoubtedSet, WithADamagedVerdictIsRefused) {
  save_text(folder_.verdict(), "none");
  EXPECT_THROW(make(), InputError);
  EXPECT_THROW(tonemap_set(folder_.root), InputError);
  fs::remove(folder_.verdict());
  EXPECT_EQ(test::digest_products(folder_.root), whole_);
}

// A picture that no program can read is one that is not that of its layers.
TEST_F(DoubtedSet, IsMendedWhereAPictureIsNone) {
  const fs::path path = folder_.root / "pictures" / (kKey + ".png");
  save_text(path, "no picture");
  change_manifest([&](Manifest& manifest) { manifest.pictures.at(kKey).digest = digest_file(path); });
  ASSERT_FALSE(verify().empty());
  EXPECT_EQ(make("*-C4-v0").pictures_written, 1u);
  EXPECT_EQ(test::digest_products(folder_.root), whole_);
}

TEST_F(DoubtedSet, StaysDoubtedByRunsThatDoNotMendIt) {
  exchange(kKey, load("G0-MS-ind-100-C0-v1"));
  const auto found = verify();
  ASSERT_FALSE(found.empty());
  EXPECT_THROW(tonemap_set(folder_.root, "nothing*"), InputError);
  const SetSummary part = tonemap_set(folder_.root, "*-v1");
  EXPECT_EQ(part.pictures_written, 0u);
  EXPECT_EQ(part.findings, found);
  EXPECT_THAT(format_summary(part),
              HasSubstr("findings of `equilux-render verify` stand, the first " + kKey));
  EXPECT_EQ(make("*-v1").findings, found);
  Json json = study_.load().source;
  json.set("name", "another");
  save_text(study_.folder() / "another.json", format_json(json));
  EXPECT_THROW(make_set({study_.folder() / "another.json", folder_.root}), InputError);
  EXPECT_THAT(find_verdict(folder_), SizeIs(1));
}

// Layers of another scene: pictures are as their layers, and only the study file tells.
TEST_F(DoubtedSet, StaysDoubtedUntilItsStudyFileIsLookedAtAgain) {
  Layers layers = load_layers(folder_.layers());
  LayerRecord& layer = layers.by_name.at(kKey);
  layer.made_from = digest_text("another");
  ExrFile file = load_exr(folder_.root / layer.file);
  file.metadata["equilux_made_from"] = layer.made_from;
  save_exr(file.image, file.metadata, folder_.root / layer.file);
  layer.digest = digest_file(folder_.root / layer.file);
  save_records(layers);
  EXPECT_THAT(verify(), IsEmpty());
  EXPECT_THAT(verify(study_.path()), SizeIs(1));
  EXPECT_THAT(tonemap_set(folder_.root).findings, SizeIs(1));
  EXPECT_THAT(verify(), SizeIs(1));
  EXPECT_THAT(make().findings, IsEmpty());
  EXPECT_EQ(test::digest_products(folder_.root), whole_);
}

TEST_F(DoubtedSet, TakesNoPictureForAnotherThatItsRecordNames) {
  const std::string other = "G0-MS-ind-100-C0-v1";
  change_manifest([&](Manifest& manifest) {
    manifest.pictures.at(kKey).file = manifest.pictures.at(other).file;
    manifest.pictures.at(kKey).digest = manifest.pictures.at(other).digest;
  });
  EXPECT_EQ(tonemap_set(folder_.root).pictures_written, 1u) << "verified or not";
  EXPECT_EQ(test::digest_products(folder_.root), whole_);
}

// What may have been shown is not mended but said.
TEST_F(DoubtedSet, WithSessionsIsNotChanged) {
  exchange(kKey, load("G0-MS-ind-100-C0-v1"));
  save_text(folder_.responses(), "a session's log stands here");
  ASSERT_FALSE(verify().empty());
  const auto before = test::digest_products(folder_.root);
  EXPECT_THAT(message_of<InputError>([&] { tonemap_set(folder_.root); }), HasSubstr("another " + kKey));
  EXPECT_EQ(test::digest_products(folder_.root), before);
}

// A study with a target, of which these few paths are far.
TEST_F(DoubtedSet, BeyondItsLimitsSaysWhatToDo) {
  const SetSummary fixed = tonemap_set(folder_.root);
  EXPECT_TRUE(is_within_limits(fixed)) << "of fixed paths";
  EXPECT_THAT(format_summary(fixed), testing::AllOf(HasSubstr("not held to it"), Not(HasSubstr("MISSED"))));
  Json json{Json::Object{}};
  const Json study = study_.load().source;
  for (const auto& [member, value] : study.as_object()) {
    if (member != "paths") json.set(member, value);
  }
  save_text(folder_.study(), format_json(json));
  Layers layers = load_layers(folder_.layers());
  Json check{Json::Array{}};
  Json row;
  row.set("region", "contact band").set("pixels", 9).set("mean", 1.0).set("standard_error", 0.1);
  row.set("path_traced", 1.0).set("path_traced_error", 0.1).set("z", 7.1);
  check.push(std::move(row));
  Json& reference = layers.by_name.at("G0-MS-ind-ref-v0.indirect").reference;
  reference.set("check", std::move(check));
  save_layers(layers, folder_.layers());
  const SetSummary summary = tonemap_set(folder_.root, "G0-MS-ind-ref-v0");
  EXPECT_FALSE(is_within_limits(summary));
  EXPECT_THAT(summary.missed,
              testing::ElementsAre("G0-MS-ind-ref-v0: its standard error is over the study's noise target",
                                   HasSubstr("G0-MS-ind-ref-v0.indirect: region contact band differs")));
  EXPECT_THAT(format_summary(summary),
              testing::AllOf(HasSubstr("beyond its limit: G0-MS-ind-ref-v0: its standard error"),
                             HasSubstr("another seed")));
}

}  // namespace
}  // namespace equilux
