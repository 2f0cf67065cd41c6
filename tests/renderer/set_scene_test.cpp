// Sets of scenes that hold less than a study asks for, or become others, and of one that holds more objects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "renderer/render_layers.h"
#include "renderer/set.h"
#include "stimuli/exr_file.h"
#include "stimuli/png_file.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

SetSummary render(const test::TinyStudy& study, const std::string& out, const std::string& only = "*") {
  return make_set({study.path(), study.folder() / out, only});
}

// Its spot shines away from everything.
constexpr const char* kDarkScene = R"({
  "schema": "equilux-scene", "schema_version": 1, "name": "dark",
  "camera": {"position": [0, -3, 0.3], "target": [0, 0, 0], "up": [0, 0, 1], "vertical_fov_degrees": 30},
  "materials": [{"name": "MS", "model": "lambertian", "rho_d": [0.5, 0.5, 0.5]},
                {"name": "GS", "model": "lambertian", "rho_d": [0.2, 0.2, 0.2]}],
  "meshes": [{"name": "ball", "sphere": {"radius": 0.5, "subdivisions": 2}}],
  "instances": [],
  "object": {"stand": [0, 0, -0.5], "geometries": [{"name": "G0", "mesh": "ball"}]},
  "lights": [{"spot": {"position": [0, -2, 3], "target": [0, -2, 9], "inner_degrees": 20,
                       "outer_degrees": 30, "intensity": [1, 1, 1]}}]
})";

TEST(SetScene, OfAWorldWithoutVplsEndsBeforeItsReferences) {
  const test::TinyStudy study("normalise");
  save_text(study.folder() / "dark.json", kDarkScene);
  Json json = parse_json(load_text(study.path()), "study");
  json.set("scene", (study.folder() / "dark.json").string());
  save_text(study.path(), format_json(json));
  try {
    render(study, "set");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("dark.json: /lights (G0-ind): expected light that"));
  }
  for (const auto& entry : fs::recursive_directory_iterator(study.folder() / "set"))
    EXPECT_NE(entry.path().extension(), ".exr") << entry.path();
}

std::string replace_once(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

// Layers would be recorded as made from the mesh that was, and show the one that is.
TEST(SetScene, WhoseMeshBecomesAnotherBeforeItIsLookedAtEndsBeforeItsReferences) {
  const test::TinyStudy tiny("normalise");
  const fs::path mesh = tiny.folder() / "read.obj", scene_path = tiny.folder() / "read.json";
  const std::string triangle = "v -1 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n";
  save_text(mesh, triangle);
  save_text(scene_path,
            replace_once(replace_once(kDarkScene, R"("sphere": {"radius": 0.5, "subdivisions": 2})",
                                      R"("file": {"path": "read.obj"})"),
                         R"("target": [0, -2, 9])", R"("target": [0, 0, 0])"));
  Json json = tiny.load().source;
  json.set("scene", scene_path.string());
  save_text(tiny.path(), format_json(json));

  const Study study = tiny.load();
  const Scene scene = load_scene(study.scene_path);
  const Wanted wanted = enumerate_wanted(study, "*");
  const Recipes recipes = make_recipes(study, scene, wanted);
  const StudyFolder folder{tiny.folder() / "set"};
  fs::create_directories(folder.layer_folder());
  LayerStore store(folder, study);
  WorkLog log(folder);
  std::map<std::string, double> seconds;
  const auto render_now = [&] { render_layers(recipes, scene, wanted, {}, store, log, seconds); };
  save_text(mesh, replace_once(triangle, "v 0 0 1", "v 0 0 2"));
  EXPECT_THAT(message_of<InputError>(render_now),
              AllOf(HasSubstr("read.json"), HasSubstr("other files of G0-ind than at the start")));
  EXPECT_TRUE(store.records().empty());
  save_text(mesh, triangle);
  render_now();
  EXPECT_FALSE(store.records().empty());
}

Json load_cafe() {
  return parse_json(load_text(std::string(EQUILUX_SOURCE_DIR) + "/stimuli/scenes/cafe.json"), "cafe");
}

// The study of another scene.
SetParams write_study_of(const Json& scene, const test::TinyStudy& study, const std::string& only) {
  save_text(study.folder() / "scene.json", format_json(scene));
  Json text = parse_json(load_text(study.path()), "study");
  text.set("scene", "scene.json");
  save_text(study.folder() / "other.json", format_json(text));
  return {study.folder() / "other.json", study.folder() / "other", only};
}

TEST(SetScene, AnObjectThatIsNotInThePictureIsWarnedOf) {
  const test::TinyStudy study;
  Json scene = load_cafe();
  Json object = scene.at("object");
  object.set("stand", parse_json("[0, 0, -50]", ""));
  scene.set("object", object);
  const auto summary = make_set(write_study_of(scene, study, "G0-MS-ind-ref-v0"));
  ASSERT_EQ(summary.warnings.size(), 1u);
  EXPECT_NE(summary.warnings[0].find("G0-MS-ind-ref-v0: the object is not in the picture"),
            std::string::npos);
}

// Nor has a picture that the object fills a background that could be black.
TEST(SetScene, AnObjectThatFillsThePictureIsNotWarnedOf) {
  const test::TinyStudy study;
  Json scene = load_cafe(), camera = scene.at("camera");
  camera.set("vertical_fov_degrees", 2);
  scene.set("camera", camera);
  EXPECT_EQ(make_set(write_study_of(scene, study, "G0-MS-ind-ref-v0")).warnings, std::vector<std::string>());
}

// Said before anything is rendered.
TEST(SetScene, AnIlluminationWithoutALightIsRefused) {
  const test::TinyStudy study;
  Json scene = load_cafe(), lights{Json::Array{}};
  for (Json light : scene.at("lights").as_array()) {
    light.set("illuminations", parse_json(R"(["dir"])", ""));
    lights.push(std::move(light));
  }
  scene.set("lights", lights);
  const SetParams params = write_study_of(scene, study, "G0-MS-*-ref-v0");
  EXPECT_THAT(message_of<InputError>([&] { make_set(params); }),
              testing::AllOf(testing::HasSubstr("scene.json: /lights"),
                             testing::HasSubstr("on under ind, got none")));
  EXPECT_FALSE(path_exists(params.folder / "layers.json"));
}

// Before anything is rendered for it. One million million VPLs or pixels need more than this machine has.
// The object is one sculpture; what is outside its coverage, the others among it, is path traced and the
// same.
TEST(SetScene, OfAGalleryTestsOneSculptureWithTheOthersInTheBackground) {
  const test::TinyStudy study("gallery");
  const test::Folder folder;
  const SetSummary summary = make_set({study.path(), folder.path(), "*ind*v0"});
  EXPECT_EQ(summary.pictures, 2u * 11 + 2);
  const HdrImage coverage = load_exr(folder / "layers/Knot-MS-ind-ref-v0.coverage.exr").image;
  const LdrImage reference = load_png(folder / "pictures/Knot-MS-ind-ref-v0.png"),
                 clamped = load_png(folder / "pictures/Knot-MS-ind-100-C8-v0.png");
  std::size_t covered = 0;
  for (std::size_t i = 0; i < coverage.values.size(); ++i) {
    covered += coverage.values[i] > 0;
    for (std::size_t c = 0; c < 3 && coverage.values[i] == 0; ++c)
      ASSERT_EQ(clamped.values[3 * i + c], reference.values[3 * i + c]);
  }
  EXPECT_GT(covered, 4u);
  EXPECT_LT(covered, 40u) << "one of six";
}

TEST(SetScene, AGeometryWhoseFileIsMissingSaysWhichAndHow) {
  // A copy of the study and its scene, beside which no mesh was ever fetched.
  const fs::path source = EQUILUX_SOURCE_DIR;
  const test::Folder folder;
  for (const char* part : {"protocols", "stimuli/scenes"}) fs::create_directories(folder.path() / part);
  for (const auto& entry : fs::directory_iterator(source / "protocols"))
    if (entry.path().extension() == ".json")
      fs::copy_file(entry.path(), folder.path() / "protocols" / entry.path().filename());
  fs::copy_file(source / "stimuli/scenes/cafe.json", folder.path() / "stimuli/scenes/cafe.json");
  try {
    make_set({folder.path() / "protocols/validation.json", folder / "set", "Bunny-*"});
    FAIL() << "there is no bunny";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("bunny.ply"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("stimuli/meshes/fetch.sh"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace equilux
