// The script for Blender, as far as it can be judged without Blender: its lists, numbers, names and syntax.
#include "renderer/export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "base/error.h"
#include "renderer/world.h"
#include "tests/experiment/child.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using test::make_scene;
using test::SceneText;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kCafe = EQUILUX_SOURCE_DIR "/stimuli/scenes/cafe.json";

ExportParams params_of(const std::string& material, Illumination illumination) {
  return {{"G0", material, illumination}, 0, 40, 30};
}

std::size_t count_lines(const std::string& script, const std::string& start) {
  std::istringstream stream(script);
  std::size_t count = 0;
  for (std::string line; std::getline(stream, line);) count += line.starts_with(start);
  return count;
}

/// Two boxes and a glossy one, a spot that is always on and a rectangle that is on in dir alone.
SceneText make_text() {
  SceneText text;
  text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.25,0.1]},
                       {"name":"metal","model":"ward-duer","rho_d":[0.1,0.1,0.1],"rho_s":[0.3,0.3,0.3],
                        "alpha":0.1},
                       {"name":"unused","model":"ward-duer","rho_d":[0,0,0],"rho_s":[0.3,0.3,0.3],
                        "alpha":0.1}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":1,"subdivisions":1}},
                    {"name":"box","box":{"size":[1,2,3]}},
                    {"name":"unused","box":{"size":[1,1,1]}}])";
  text.instances = R"([{"mesh":"box","material":"grey","at":[1,2,3],"turn_degrees":30,"tilt_degrees":-5},
                       {"mesh":"box","material":"metal","at":[0.1,0,0],"scale":2},
                       {"mesh":"box","material":"grey","at":[0,0,0]}])";
  text.lights = R"([{"spot":{"position":[0,-4,0],"target":[0,0,0],"inner_degrees":20,"outer_degrees":40,
                             "intensity":[1.5,2,0.3]}},
                    {"rectangle":{"corner":[0,0,4],"u":[0,1,0],"v":[1,0,0],"radiance":[7,8,9]},
                     "illuminations":["dir"]}])";
  return text;
}

int compile_python(const std::string& script) {
  const test::Folder folder;
  save_text(folder / "script.py", script);
  return Child("/usr/bin/python3", {"-m", "py_compile", (folder / "script.py").string()}).wait().exit_code;
}

TEST(Export, HoldsEveryLightThatIsOnAndNoOther) {
  const Scene scene = make_scene(make_text());
  const auto indirect = make_diffuse_scene(scene, params_of("grey", Illumination::kIndirect));
  const auto direct = make_diffuse_scene(scene, params_of("grey", Illumination::kDirectAndIndirect));
  EXPECT_EQ(indirect.spots.size(), 1u);
  EXPECT_EQ(indirect.rectangles.size(), 0u);
  EXPECT_EQ(direct.spots.size(), 1u);
  ASSERT_EQ(direct.rectangles.size(), 1u);
  EXPECT_EQ(direct.rectangles[0].radiance_w_per_m2_sr, (Vec3{7, 8, 9}));
  const std::string script = format_blender_script(indirect);
  EXPECT_EQ(count_lines(script, "spot("), 1u);
  EXPECT_EQ(count_lines(script, "rectangle("), 0u);
  EXPECT_EQ(
      count_lines(format_blender_script(direct), "rectangle((0, 0, 4), (0, 1, 0), (1, 0, 0), (7, 8, 9))"),
      1u);
}

TEST(Export, HasTheEnvironmentWhereItIsOn) {
  SceneText text = make_text();
  text.lights = R"([{"environment":{"radiance":[1,2,0.5]},"illuminations":["dir"]}])";
  const Scene scene = make_scene(text);
  const auto script_of = [&](Illumination illumination) {
    return format_blender_script(make_diffuse_scene(scene, params_of("grey", illumination)));
  };
  EXPECT_EQ(count_lines(script_of(Illumination::kIndirect), "start((0, 0, 0))"), 1u);
  EXPECT_EQ(count_lines(script_of(Illumination::kDirectAndIndirect), "start((1, 2, 0.5))"), 1u);
}

TEST(Export, WritesEachMeshThatIsSeenOnceAndPlacesEveryInstance) {
  const auto diffuse =
      make_diffuse_scene(make_scene(make_text()), params_of("grey", Illumination::kIndirect));
  const std::string script = format_blender_script(diffuse);
  EXPECT_EQ(count_lines(script, "meshes.append("), 2u) << "ball and box";
  EXPECT_EQ(count_lines(script, "place("), 4u) << "the object and three boxes";
  EXPECT_EQ(count_lines(script, "    material(\""), 2u) << "grey and metal";
  EXPECT_EQ(count_triangles(diffuse), 80u + 3 * 12u);
  EXPECT_THAT(script, HasSubstr("place(meshes[1], materials[0], (1, 2, 3), 30, -5, 1)\n"
                                "place(meshes[1], materials[1], (0.1, 0, 0), 0, 0, 2)\n"));
}

// Rows between the quotes of a mesh: positions, triangles, normals.
TEST(Export, WritesEveryVertexAndTriangle) {
  const auto diffuse =
      make_diffuse_scene(make_scene(make_text()), params_of("grey", Illumination::kIndirect));
  const std::string script = format_blender_script(diffuse);
  std::size_t vertices = 0, normals = 0, triangles = 0;
  for (const auto& mesh : diffuse.meshes) {
    vertices += mesh.mesh.positions.size();
    normals += mesh.mesh.normals.size();
    triangles += mesh.mesh.triangles.size();
  }
  std::size_t rows = 0;
  std::istringstream stream(script);
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    double a, b, c;
    rows += (words >> a >> b >> c) && words.eof();
  }
  EXPECT_EQ(diffuse.meshes[0].mesh.positions.size(), 42u) << "a ball of one subdivision";
  EXPECT_EQ(rows, vertices + normals + triangles);
}

TEST(Export, HasTheTrianglesOfTheWorldThatIsRendered) {
  const Scene scene = load_scene(kCafe);
  for (const Illumination illumination : {Illumination::kIndirect, Illumination::kDirectAndIndirect}) {
    const auto diffuse = make_diffuse_scene(scene, params_of("LG", illumination));
    const World world = make_world(scene, "G0", illumination);
    EXPECT_EQ(count_triangles(diffuse) + 2 * diffuse.rectangles.size(), world.triangle_count());
    EXPECT_EQ(diffuse.spots.size(), world.spots().size());
    EXPECT_EQ(diffuse.rectangles.size(), world.rectangles().size());
  }
}

TEST(Export, OfOneSculptureHasTheOthersInTheRoom) {
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/gallery.json");
  ExportParams params = params_of("LG", Illumination::kIndirect);
  params.object.geometry = "Knot";
  const auto diffuse = make_diffuse_scene(scene, params);
  EXPECT_EQ(count_triangles(diffuse), make_world(scene, "Knot", Illumination::kIndirect).triangle_count());
  EXPECT_EQ(diffuse.surfaces.size(), scene.instances.size() + scene.sculptures.size());
}

TEST(Export, SaysWhichGlossyPartsItLeavesOut) {
  const Scene scene = make_scene(make_text());
  const auto grey = make_diffuse_scene(scene, params_of("grey", Illumination::kIndirect));
  EXPECT_THAT(find_glossy_materials(grey), ElementsAre("metal"))
      << "a material that is not seen is not named";
  EXPECT_THAT(format_blender_script(grey), HasSubstr("Left out is the glossy part of \"metal\".\n"));
  SceneText text = make_text();
  text.instances = "[]";
  const auto alone = make_diffuse_scene(make_scene(text), params_of("grey", Illumination::kIndirect));
  EXPECT_THAT(format_blender_script(alone), Not(HasSubstr("Left out")));
}

TEST(Export, GivesTheSameTextForTheSameSceneAndAnotherForAnotherView) {
  const Scene scene = make_scene(make_text());
  ExportParams params = params_of("grey", Illumination::kIndirect);
  const std::string script = format_blender_script(make_diffuse_scene(scene, params));
  EXPECT_EQ(format_blender_script(make_diffuse_scene(scene, params)), script);
  params.view = 1;
  EXPECT_NE(format_blender_script(make_diffuse_scene(scene, params)), script);
}

TEST(Export, KeepsTheExactValueOfEveryNumber) {
  SceneText text = make_text();
  text.camera =
      R"({"position":[0.1,-3.3333333,1e-7],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":28.5})";
  const auto diffuse = make_diffuse_scene(make_scene(text), params_of("grey", Illumination::kIndirect));
  EXPECT_THAT(format_blender_script(diffuse),
              HasSubstr("camera((0.1, -3.3333333, 1e-07), (0, 0, 0), (0, 0, 1), 28.5, 40, 30)"));
}

TEST(Export, IsPythonForTheCafe) {
  const auto diffuse =
      make_diffuse_scene(load_scene(kCafe), params_of("MS", Illumination::kDirectAndIndirect));
  EXPECT_EQ(compile_python(format_blender_script(diffuse)), 0);
}

TEST(Export, IsPythonWhateverTheNamesAre) {
  SceneText text = make_text();
  const std::string name = R"(\"\"\"\\\n';import os#é)";
  text.materials = R"([{"name":")" + name + R"(","model":"ward-duer","rho_d":[0.5,0.5,0.5],
                        "rho_s":[0.1,0.1,0.1],"alpha":0.1}])";
  text.instances = "[]";
  const Scene scene = make_scene(text);
  const std::string script = format_blender_script(
      make_diffuse_scene(scene, params_of(scene.materials[0].name, Illumination::kIndirect)));
  EXPECT_THAT(script, HasSubstr(R"(material("\"\"\"\\\x0a';import os#é", (0.5, 0.5, 0.5)))"));
  EXPECT_EQ(compile_python(script), 0);
  EXPECT_NE(compile_python(script + "material(\n"), 0) << "mutant: a list without its end";
}

TEST(Export, NamesAnObjectThatTheSceneLacks) {
  const Scene scene = make_scene(make_text());
  ExportParams params = params_of("velvet", Illumination::kIndirect);
  EXPECT_THAT(message_of<InputError>([&] { make_diffuse_scene(scene, params); }), HasSubstr("velvet"));
  params.object = {"G9", "grey", Illumination::kIndirect};
  EXPECT_THAT(message_of<InputError>([&] { make_diffuse_scene(scene, params); }), HasSubstr("G9"));
}

}  // namespace
}  // namespace equilux
