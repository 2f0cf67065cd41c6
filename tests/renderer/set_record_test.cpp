// What a set tells of its layers: method, error, instruction set; by lightcuts and compensated references.
#include <cmath>
#include <gtest/gtest.h>

#include "base/files.h"
#include "renderer/isa.h"
#include "renderer/set.h"
#include "stimuli/layers.h"
#include "stimuli/manifest.h"
#include "tests/renderer/tiny_study.h"

namespace equilux {
namespace {

// 30,000 VPLs go by lightcuts: level by level and material by material they give the layers of all at once.
TEST(SetRecord, OfManyVplsIsCutTheSameWhateverItIsMadeWith) {
  const test::TinyStudy study("many");
  const test::Folder whole, parts;
  make_set({study.path(), whole.path(), "G0-*-ind-*v0"});
  for (const char* only : {"G0-MS-ind-30k-C4-v0", "G0-GS-ind-30k-C[0-6]-v0", "G0-*-ind-*v0"})
    make_set({study.path(), parts.path(), only});
  for (const char* key : {"G0-MS-ind-30k-C0-v0", "G0-MS-ind-30k-C4-v0", "G0-GS-ind-30k-C10-v0"}) {
    const std::string file = std::string("layers/") + key + ".exr";
    EXPECT_EQ(load_text(whole / file), load_text(parts / file)) << key;
  }
}

// Layers and manifest say of each reference by which method it was made; another method is another recipe.
TEST(SetRecord, TellsHowReferencesWereMadeAndHowTheyAgreeWithPaths) {
  const test::TinyStudy sets("compensated"), paths;
  const test::Folder folder, other;
  EXPECT_EQ(make_set({sets.path(), folder.path(), "G0-GS-ind-ref-v0"}).pictures, 1u);
  const Json made = load_manifest(folder / "manifest.json").pictures.at("G0-GS-ind-ref-v0").reference;
  EXPECT_EQ(made, load_layers(folder / "layers.json").by_name.at("G0-GS-ind-ref-v0.indirect").reference);
  EXPECT_EQ(made.at("method").as_string(), "compensated");
  EXPECT_GE(made.at("sets").as_int(), 8);
  EXPECT_GT(made.at("paths").as_double(), 0);
  EXPECT_GE(made.at("check").as_array().size(), 6u);
  for (const Json& region : made.at("check").as_array())
    EXPECT_LT(std::abs(region.at("z").as_double()), 7) << region.at("region").as_string();
  const SetSummary again = make_set({sets.path(), folder.path(), "G0-GS-ind-ref-v0"});
  EXPECT_EQ(again.layers_rendered, 0u);
  EXPECT_EQ(load_manifest(folder / "manifest.json").pictures.at("G0-GS-ind-ref-v0").reference, made);
  make_set({paths.path(), other.path(), "G0-GS-ind-ref-v0"});
  const Json traced = load_manifest(other / "manifest.json").pictures.at("G0-GS-ind-ref-v0").reference;
  EXPECT_EQ(traced.at("method").as_string(), "path");
  EXPECT_FALSE(traced.find("check"));
}

// Every VPL picture's record says how it was made and what its error is; the summary pools what is measured.
TEST(SetRecord, TellsOfEveryVplPictureHowItWasMadeAndItsMeasuredError) {
  const test::TinyStudy many("many"), few;
  const test::Folder cuts, sums;
  const SetSummary summary = make_set({many.path(), cuts.path(), "G0-MS-ind-*v0"});
  ASSERT_EQ(summary.cut_errors.size(), 1u);
  const ErrorSummary pooled = summary.cut_errors.at(30000);
  EXPECT_GT(pooled.points, 11u * 50);
  EXPECT_GT(pooled.rms, 0.0005);
  EXPECT_LT(pooled.p99, 0.06);
  const auto vpls_of = [](const test::Folder& folder, const std::string& key) {
    return load_manifest(folder / "manifest.json").pictures.at(key).vpls;
  };
  const Json cut = vpls_of(cuts, "G0-MS-ind-30k-C4-v0"), sum_before = vpls_of(cuts, "G0-MS-ind-30k-C8-v0");
  EXPECT_EQ(cut.at("method").as_string(), "lightcut");
  EXPECT_EQ(cut.at("error_ratio").as_double(), 0.0075);
  EXPECT_NEAR(static_cast<double>(cut.at("count").as_int()), 30000, 1500);
  EXPECT_GT(cut.at("shadow_rays").as_int(), 1000);
  EXPECT_GT(cut.at("cut_size").at("max").as_double(), 100);
  EXPECT_EQ(cut.at("error").at("against").as_string(), "plain sum");
  EXPECT_NE(cut.at("error"), sum_before.at("error")) << "each level has its own";
  make_set({few.path(), sums.path(), "G0-MS-ind-*v0"});
  const Json sum = vpls_of(sums, "G0-MS-ind-100-C4-v0");
  EXPECT_EQ(sum.at("method").as_string(), "plain sum");
  EXPECT_GT(sum.at("shadow_rays").as_int(), 1000);
  EXPECT_TRUE(load_manifest(sums / "manifest.json").pictures.at("G0-MS-ind-ref-v0").vpls.is_null());
  // What a second run finds whole it tells again, to the byte.
  const std::string before = load_text(cuts / "manifest.json");
  const SetSummary again = make_set({many.path(), cuts.path(), "G0-MS-ind-*v0"});
  EXPECT_EQ(again.layers_rendered, 0u);
  EXPECT_EQ(again.cut_errors.at(30000).p99, pooled.p99);
  EXPECT_EQ(load_text(cuts / "manifest.json"), before);
}

TEST(SetRecord, OfTwoInstructionSetsIsWarnedOf) {
  const test::TinyStudy study;
  const test::Folder folder;
  EXPECT_TRUE(make_set({study.path(), folder.path(), "G0-MS-ind-*v0"}).warnings.empty());
  Layers layers = load_layers(folder / "layers.json");
  LayerRecord& one = layers.by_name.at("G0-MS-ind-100-C4-v0");
  const std::string mine = format_isa(current_isa());
  EXPECT_EQ(one.isa, mine);
  one.isa = mine == "v4" ? "v3" : "v4";
  save_layers(layers, folder / "layers.json");
  const SetSummary mixed = make_set({study.path(), folder.path(), "G0-MS-ind-*v0"});
  EXPECT_EQ(mixed.layers_rendered, 0u);
  ASSERT_EQ(mixed.warnings.size(), 1u);
  EXPECT_NE(mixed.warnings[0].find("1 by " + one.isa), std::string::npos) << mixed.warnings[0];
  // What an older program made does not say.
  one.isa = "";
  save_layers(layers, folder / "layers.json");
  EXPECT_TRUE(make_set({study.path(), folder.path(), "G0-MS-ind-*v0"}).warnings.empty());
}

TEST(SetRecord, OfACertifiedStudyErrsByUnderOnePerCentAtNinetyNineOfAHundredPoints) {
  const test::TinyStudy study("many");
  Json json = study.load().source;
  save_text(study.path(), format_json(json.set("certified", true)));
  const test::Folder folder;
  const SetSummary summary = make_set({study.path(), folder.path(), "G0-MS-ind-*v0"});
  EXPECT_LT(summary.cut_errors.at(30000).p99, 0.01);
}

}  // namespace
}  // namespace equilux
