// A set that was tampered with in one place each: the finding names it.
#include "renderer/verify.h"

#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "renderer/record_check.h"
#include "renderer/set.h"
#include "stimuli/exr_file.h"
#include "stimuli/layers.h"
#include "stimuli/origin.h"
#include "stimuli/png_file.h"
#include "tests/renderer/rendered_set.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

using Verify = test::RenderedSet;

TEST_F(Verify, FindsNothingInASetAsItWasMade) {
  const Verification whole = verify_set(folder_.root, study_.path());
  EXPECT_EQ(whole.findings, std::vector<Finding>());
  EXPECT_EQ(whole.pictures, 8u + 88u);
  EXPECT_EQ(whole.layers, 8u * 5 + 88);
  EXPECT_EQ(find(), std::vector<std::string>()) << "and changes nothing";
}

TEST_F(Verify, LayersSayInTheirFilesWhatTheyAre) {
  const auto attributes = [&](const std::string& name) {
    return load_exr(folder_.root / "layers" / (name + ".exr")).metadata;
  };
  const ExrMetadata vpls = attributes("G0-MS-ind-100-C4-v1"),
                    coverage = attributes("G0-MS-ind-ref-v1.coverage");
  const Study study = study_.load();
  for (const ExrMetadata& layer : {vpls, coverage}) {
    EXPECT_EQ(layer.at("equilux_study"), study.name);
    EXPECT_EQ(layer.at("equilux_seed"), "1");
    EXPECT_EQ(layer.at("equilux_version"), kVersion);
    EXPECT_EQ(layer.at("equilux_made_from").size(), 64u);
  }
  EXPECT_EQ(vpls.at("equilux_unit"), "W/(m^2 sr)");
  EXPECT_EQ(coverage.at("equilux_unit"), "1");
  EXPECT_EQ(vpls.at("equilux_key"), "G0-MS-ind-100-C4-v1");
  EXPECT_EQ(coverage.at("equilux_key"), "G0-MS-ind-ref-v1.coverage");
  EXPECT_EQ(vpls.at("equilux_clamp_per_m2"), fmt::format("{}", clamp_per_m2(4)));
  EXPECT_GT(std::stol(vpls.at("equilux_vpl_count")), 50);
  EXPECT_FALSE(coverage.contains("equilux_clamp_per_m2"));
}

TEST_F(Verify, FindsAPictureOrLayerThatIsNotThere) {
  fs::remove(folder_.root / "pictures/G0-MS-ind-100-C4-v0.png");
  expect_only("G0-MS-ind-100-C4-v0: no file");
  change_manifest([](Manifest& manifest) { manifest.pictures.erase("G0-MS-ind-100-C4-v0"); });
  expect_only("G0-MS-ind-100-C4-v0: no picture");
  fs::remove(folder_.root / "layers/G0-GS-dir-100-C0-v1.exr");
  const auto lines = find();
  ASSERT_EQ(lines.size(), 2u) << testing::PrintToString(lines);
  EXPECT_THAT(lines[1], HasSubstr("G0-GS-dir-100-C0-v1"));
  fs::remove(folder_.layers());
  EXPECT_EQ(find().size(), 1u + 8u) << "one for each family, not one for each picture";
  fs::remove(folder_.manifest());
  EXPECT_THAT(find()[0], HasSubstr("no pictures were made"));
}

// A pipe would be waited for.
TEST_F(Verify, FindsAPictureThatIsNoFile) {
  const fs::path picture = folder_.root / "pictures/G0-MS-ind-100-C4-v0.png";
  fs::remove(picture);
  ASSERT_EQ(::mkfifo(picture.c_str(), 0600), 0);
  expect_only("G0-MS-ind-100-C4-v0: no file");
}

// Sparse, so that it takes no disk; 24 x 18 pixels of floats are 7 KiB.
TEST_F(Verify, ReadsNoMoreOfAFileThanItsPixelsTake) {
  const fs::path layer = folder_.root / "layers/G0-MS-ind-100-C3-v0.exr";
  fs::resize_file(layer, std::uintmax_t{1} << 40);
  expect_only("C3-v0.exr: expected at most 67115776 bytes, got more");
  fs::remove(layer);
  fs::remove(folder_.root / "pictures/G0-MS-ind-100-C4-v0.png");
  std::ofstream(folder_.root / "pictures/G0-MS-ind-100-C4-v0.png").put('a');
  fs::resize_file(folder_.root / "pictures/G0-MS-ind-100-C4-v0.png", std::uintmax_t{1} << 40);
  const auto lines = find();
  EXPECT_THAT(lines.at(0), HasSubstr("C4-v0.png: expected at most 67115776 bytes, got more"));
}

TEST_F(Verify, FindsAByteThatWasChanged) {
  const fs::path path = folder_.root / "layers/G0-MS-ind-ref-v0.indirect.exr";
  std::string bytes = load_text(path);
  bytes[bytes.size() - 3] ^= 1;
  save_text(path, bytes);
  expect_only("G0-MS-ind-ref-v0: ");
}

TEST_F(Verify, FindsAPictureWithOtherPixelsThanItsLayers) {
  const std::string key = "G0-MS-ind-100-C4-v1";
  const fs::path path = folder_.root / "pictures" / (key + ".png");
  LdrImage picture = load_png(path);
  picture.values[0] ^= 1;  // wall
  save_png(picture, path);
  change_manifest([&](Manifest& manifest) { manifest.pictures.at(key).digest = digest_file(path); });
  const auto lines = find();
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_THAT(lines[0], HasSubstr(key + ": the picture is not that of its layers"));
  EXPECT_THAT(lines[1], HasSubstr(key + ": its background is not that of its reference"));
}

TEST_F(Verify, FindsLightOutsideItsPlaceAndBelowNothing) {
  change_layer("G0-MS-ind-100-C4-v1", [](HdrImage& layer) { layer.values[0] = 0.5f; });
  auto lines = find();
  ASSERT_GE(lines.size(), 2u);
  EXPECT_THAT(lines[0], HasSubstr("G0-MS-ind-100-C4-v1: light outside its place, at pixel 0"));
  change_layer("G0-MS-ind-100-C4-v1", [](HdrImage& layer) { layer.values[0] = -0.5f; });
  EXPECT_THAT(find()[0],
              HasSubstr("G0-MS-ind-100-C4-v1.exr: pixel (0, 0): expected a value of 0 or more, got -0.5"));
}

TEST_F(Verify, FindsALevelBrighterThanAWeakerClamp) {
  change_layer("G0-GS-ind-100-C5-v0", [](HdrImage& layer) {
    for (float& value : layer.values) value *= 3;
  });
  const auto lines = find();
  ASSERT_EQ(lines.size(), 2u) << testing::PrintToString(lines);
  EXPECT_THAT(lines[0], HasSubstr("the picture is not that of its layers"));
  EXPECT_THAT(lines[1], HasSubstr("G0-GS-ind-100-C5-v0: brighter than under a weaker clamp"));
}

TEST_F(Verify, FindsAToneCurveOrAnErrorThatLayersDoNotGive) {
  change_manifest([](Manifest& manifest) { manifest.tones.at("G0-MS-ind-ref-v0").white *= 1.001; });
  EXPECT_EQ(find().size(), 1u + 11u + 1u) << "of another curve than its pictures were made by, too";
  save_records(load_layers(folder_.layers()));
  expect_only("G0-MS-ind-ref-v0: its tone curve in the manifest is not that of its layers");
  change_manifest([](Manifest& manifest) {
    manifest.tones.at("G0-MS-ind-ref-v0").white /= 1.001;
    manifest.pictures.at("G0-GS-dir-ref-v1").standard_error.set("object_mean", 0.125);
  });
  save_records(load_layers(folder_.layers()));
  expect_only("G0-GS-dir-ref-v1: its object_mean in the manifest is 0.125");
}

TEST_F(Verify, FindsPicturesOfAnotherStudyAndLayersOfAnotherScene) {
  Layers layers = load_layers(folder_.layers());
  layers.by_name.at("G0-MS-ind-100-C3-v0").made_from = digest_text("another");
  save_records(layers);
  expect_only("G0-MS-ind-100-C3-v0.exr: equilux_made_from: expected ");
  // With a file that says the same by the folder alone it cannot be told.
  LayerRecord& layer = layers.by_name.at("G0-MS-ind-100-C3-v0");
  ExrFile file = load_exr(folder_.root / layer.file);
  file.metadata["equilux_made_from"] = layer.made_from;
  save_exr(file.image, file.metadata, folder_.root / layer.file);
  layer.digest = digest_file(folder_.root / layer.file);
  save_records(layers);
  EXPECT_EQ(find(), std::vector<std::string>());
  const auto lines = find(study_.path());
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], HasSubstr("G0-MS-ind-100-C3-v0: made from another study, scene or estimator"));
  const test::TinyStudy other(study_.folder(), 7);
  EXPECT_THAT(message_of<InputError>([&] { find(other.path()); }),
              HasSubstr("expected the study of the folder"));
  change_manifest([](Manifest& manifest) { manifest.study_digest = digest_text("another"); });
  expect_only("of another study than study.json");
}

TEST_F(Verify, FindsALayerOfOtherChannelsAndAPictureOfAnotherSize) {
  Layers layers = load_layers(folder_.layers());
  LayerRecord& layer = layers.by_name.at("G0-MS-ind-100-C3-v0");
  layer.file = layers.by_name.at("G0-MS-ind-ref-v0.coverage").file;
  layer.digest = layers.by_name.at("G0-MS-ind-ref-v0.coverage").digest;
  save_records(layers);
  expect_only("G0-MS-ind-100-C3-v0: ");
  for (const std::string key : {"G0-MS-ind-ref-v0", "G0-MS-ind-100-C4-v0"}) {
    save_png(LdrImage(1, 1), folder_.root / "pictures" / (key + ".png"));
    change_manifest([&](Manifest& manifest) {
      manifest.pictures.at(key).digest = digest_file(folder_.root / manifest.pictures.at(key).file);
    });
  }
  const auto lines = find();
  EXPECT_THAT(lines[0], HasSubstr("1 x 1 pixels, where the manifest has 24 x 18"));
}

// Files and digests of two layers that have changed places: each file says what it is.
TEST_F(Verify, FindsLayersThatStandForOneAnother) {
  const auto names = [](const char* a, const char* b) { return std::pair<std::string, std::string>(a, b); };
  const Layers before = load_layers(folder_.layers());
  for (const auto& [one, other] : {names("G0-MS-ind-100-C4-v0", "G0-GS-ind-100-C4-v0"),
                                   names("G0-MS-ind-100-C0-v0", "G0-MS-ind-100-C10-v0"),
                                   names("G0-MS-ind-ref-v0.indirect", "G0-GS-ind-ref-v0.indirect")}) {
    Layers layers = before;
    std::swap(layers.by_name.at(one).file, layers.by_name.at(other).file);
    std::swap(layers.by_name.at(one).digest, layers.by_name.at(other).digest);
    save_records(layers);
    const auto lines = find();
    ASSERT_EQ(lines.size(), 2u) << testing::PrintToString(lines);
    for (const std::string& line : lines) EXPECT_THAT(line, HasSubstr("equilux_key: expected ")) << one;
  }
}

TEST_F(Verify, FindsAManifestOfOtherPixelsSeedOrTarget) {
  const Manifest before = load_manifest(folder_.manifest());
  const auto expect_other = [&](const std::string& what, const auto& change) {
    Manifest manifest = before;
    change(manifest);
    save_manifest(manifest, folder_.manifest());
    expect_only(what);
  };
  expect_other("seed 9, where the study has 1", [](Manifest& manifest) { manifest.seed = 9; });
  expect_other("of the study \"mine\"", [](Manifest& manifest) { manifest.study_name = "mine"; });
  expect_other("another noise target", [](Manifest& manifest) { manifest.noise_target->object_p99 += 1; });
  // A set of pictures that are all too small.
  for (const auto& [key, record] : before.pictures) save_png(LdrImage(1, 1), folder_.root / record.file);
  const std::string small = digest_file(folder_.root / before.pictures.begin()->second.file);
  expect_other("pictures of 1 x 1 pixels, where the study has 24 x 18", [&](Manifest& manifest) {
    manifest.width = manifest.height = 1;
    for (auto& [key, record] : manifest.pictures) record.digest = small;
  });
}

TEST_F(Verify, FindsAnErrorThatIsNoneAndMethodsWithoutTheirProof) {
  change_layer("G0-MS-dir-ref-v1.standard_error",
               [](HdrImage& image) { image.values.assign(image.values.size(), 0); });
  tonemap_set(folder_.root, "*");
  expect_only("G0-MS-dir-ref-v1.standard_error: black, where light was sampled");
  LayerRecord record;
  Study study = study_.load();
  EXPECT_EQ(find_unchecked(record, study), "") << "of fixed paths";
  study.paths.reset();
  study.reference = ReferenceMethod::kCompensated;
  EXPECT_THAT(find_unchecked(record, study), HasSubstr("does not say how it was made"));
  record.reference = Json().set("method", "compensated");
  EXPECT_THAT(find_unchecked(record, study), HasSubstr("without the path-traced check"));
  record.reference.set("check", Json(Json::Array{}));
  EXPECT_EQ(find_unchecked(record, study), "");
  record.reference = Json().set("method", "path");
  EXPECT_EQ(find_unchecked(record, study), "") << "where sets are dearer";
  EXPECT_THAT(find_uncertified(record, true), HasSubstr("does not say whether"));
  EXPECT_EQ(find_uncertified(record, false), "");
  record.vpls = Json().set("certified", true);
  EXPECT_EQ(find_uncertified(record, true), "");
}

// It says which pixels are the background, and how errors are told: half everywhere would let anything pass.
TEST_F(Verify, FindsACoverageThatIsNotThatOfOtherMaterials) {
  change_layer("G0-GS-ind-ref-v0.coverage",
               [](HdrImage& image) { image.values.assign(image.values.size(), 0.5f); });
  change_layer("G0-GS-ind-ref-v0.standard_error",
               [](HdrImage& image) { image.values.assign(image.values.size(), 1e-9f); });
  tonemap_set(folder_.root, "G0-GS-ind-*-v0");
  expect_only(
      "G0-GS-ind-ref-v0.coverage: not that of G0-MS-ind-ref-v0, of the same object in another material");
}

TEST_F(Verify, NotesThatAStudyOfFixedPathsHasNoLimitForItsErrors) {
  const auto notes = verify_set(folder_.root, {}).notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_THAT(notes[0], HasSubstr("the study fixes its paths"));
}

TEST_F(Verify, NotesAnObjectWithoutLight) {
  for (const char* content : {"direct", "indirect"})
    change_layer(fmt::format("G0-GS-dir-ref-v1.{}", content),
                 [](HdrImage& image) { std::fill(image.values.begin(), image.values.end(), 0.0f); });
  EXPECT_THAT(verify_set(folder_.root, {}).notes,
              testing::Contains("G0-GS-dir-ref-v1: no light on the object"));
}

TEST_F(Verify, NotesRegionsWhosePathTracedCheckKnowsNothing) {
  Layers layers = load_layers(folder_.layers());
  Json check{Json::Array{}};
  for (const auto& [mean, traced, error] :
       {std::tuple{1.0, 1.0, 0.1}, {1.0, 1.0, 0.2}, {1.0, 0.0, 0.0}, {0.0, 0.0, 0.0}}) {
    Json row;
    row.set("region", "r1c1").set("pixels", 9).set("mean", mean).set("standard_error", 0.1);
    row.set("path_traced", traced).set("path_traced_error", error).set("z", 0.0);
    check.push(std::move(row));
  }
  layers.by_name.at("G0-GS-dir-ref-v1.indirect").reference.set("check", std::move(check));
  save_records(layers);
  EXPECT_THAT(verify_set(folder_.root, {}).notes,
              testing::Contains(HasSubstr("in 2 of 4 regions of references the paths")));
}

TEST_F(Verify, FindsAPictureThatTheStudyDoesNotHave) {
  change_manifest(
      [](Manifest& manifest) { manifest.pictures["foo"] = manifest.pictures.at("G0-MS-ind-100-C4-v0"); });
  expect_only("foo: recorded in the manifest, and no picture of the study");
}

TEST_F(Verify, FindsWhatTheRecordsSayAgainstTheirLayers) {
  Layers layers = load_layers(folder_.layers());
  Json& vpls = layers.by_name.at("G0-MS-ind-100-C3-v0").vpls;
  vpls.set("certified", true);
  Json& reference = layers.by_name.at("G0-GS-dir-ref-v1.indirect").reference;
  const auto set_check = [&](double z) {
    Json check{Json::Array{}};
    Json row;
    row.set("region", "contact band").set("pixels", 9).set("mean", 1.0).set("standard_error", 0.1);
    row.set("path_traced", 1.0).set("path_traced_error", 0.1).set("z", z);
    check.push(std::move(row));
    reference.set("check", std::move(check));
    save_records(layers);
  };
  set_check(-6.9);
  EXPECT_EQ(find(), std::vector<std::string>()) << "certified, and nearer than chance may be";
  set_check(-7.1);
  expect_only(
      "G0-GS-dir-ref-v1.indirect: region contact band differs from its path-traced check by -7.1 standard "
      "errors");
  vpls.set("certified", false);
  set_check(0);
  expect_only("G0-MS-ind-100-C3-v0: not certified, more than 1 % of its points err by 1 % or more");
}

// Which counts, errors and methods a manifest tells of is what analyses and papers quote.
TEST_F(Verify, FindsAManifestThatTellsOtherThanItsLayers) {
  const Manifest before = load_manifest(folder_.manifest());
  const auto expect_found = [&](const std::string& what, const auto& change) {
    Manifest manifest = before;
    change(manifest.pictures);
    save_manifest(manifest, folder_.manifest());
    expect_only(what);
    tonemap_set(folder_.root, "*");
    EXPECT_EQ(find(), std::vector<std::string>()) << "written anew";
  };
  const std::string vpls = "G0-MS-ind-100-C4-v0", reference = "G0-GS-dir-ref-v1";
  const std::string other = ": what the manifest tells of its making is not what layers.json tells";
  expect_found(vpls + other, [&](auto& pictures) { pictures.at(vpls).vpls.set("count", 5); });
  expect_found(vpls + other, [&](auto& pictures) { pictures.at(vpls).vpls = {}; });
  expect_found(reference + other, [&](auto& pictures) { pictures.at(reference).reference.set("paths", 7); });
  expect_found(reference + ": its standard error is not in the manifest",
               [&](auto& pictures) { pictures.at(reference).standard_error = {}; });
}

TEST_F(Verify, FindsLayersRecordedForAnotherStudyOrSeed) {
  const Layers before = load_layers(folder_.layers());
  Layers layers = before;
  layers.seed = 77;
  save_layers(layers, folder_.layers());
  expect_only("layers.json: seed 77, where the study has 1");
  layers = before;
  layers.study_name = "other";
  save_layers(layers, folder_.layers());
  expect_only("layers.json: of the study \"other\", where study.json has ");
}

TEST_F(Verify, FindsALayerWhoseFileTellsAnotherCountOfVpls) {
  Layers layers = load_layers(folder_.layers());
  ++layers.by_name.at("G0-MS-ind-100-C4-v0").vpl_count;
  save_records(layers);
  expect_only("C4-v0.exr: equilux_vpl_count: expected ");
}

TEST_F(Verify, FindsSharesThatAreNotGathered) {
  fs::create_directories(folder_.job("1-of-2"));
  expect_only("shares that are not gathered");
}

TEST(VerifyFolder, ThatIsNoStudyFolderIsRefused) {
  const TempFolder folder;
  EXPECT_THAT(message_of<InputError>([&] { verify_set(folder.path(), {}); }),
              HasSubstr("expected a study folder"));
}

}  // namespace
}  // namespace equilux
