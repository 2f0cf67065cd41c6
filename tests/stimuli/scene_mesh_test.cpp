// Meshes in the world: where the object stands, how placements turn, and where the two cameras are.
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/stimuli/mesh_measures.h"
#include "tests/stimuli/small_scene.h"
#include "tests/support/failures.h"
#include "tests/support/json_edit.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Scene load_cafe() {
  return load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
}

void expect_near(Vec3 a, Vec3 b, float tolerance = 1e-6f) {
  EXPECT_LT(length(a - b), tolerance)
      << "(" << a.x << ", " << a.y << ", " << a.z << ") and (" << b.x << ", " << b.y << ", " << b.z << ")";
}

TEST(MakeObject, TouchesTheStandAtItsLowestPoint) {
  const Scene scene = load_cafe();
  for (const char* geometry : {"G0", "G1", "G2", "G3"}) {
    const TriangleMesh mesh = make_object(scene, geometry);
    float lowest = 1e9f;
    for (Vec3 p : mesh.positions) lowest = std::min(lowest, p.z);
    EXPECT_NEAR(lowest, scene.stand.z, 1e-6) << geometry;
    const double radius = std::cbrt(volume_of(mesh) * 3 / (4 * std::numbers::pi));
    EXPECT_NEAR(radius, 0.45, 0.02) << geometry << ": that of the sphere of its volume";
    EXPECT_TRUE(is_closed(mesh)) << geometry;
  }
}

TEST(MakeObject, FromAMissingFileSaysHowToGetIt) {
  // Beside a copy of the scene no mesh was ever fetched.
  const TempFolder folder;
  const Scene scene = load_scene(folder.write("cafe.json", load_text(load_cafe().path)));
  for (const char* geometry : {"Bunny", "Dragon"}) {
    EXPECT_THAT(message_of<InputError>([&] { make_object(scene, geometry); }),
                AllOf(HasSubstr("cafe.json"), HasSubstr("the file "), HasSubstr(".ply"),
                      HasSubstr("brings the Stanford"), HasSubstr("stimuli/meshes/fetch.sh")));
  }
}

TEST(FindMissingFile, LooksIntoGroupsAndIsEmptyWhereAllIsThere) {
  const TempFolder folder;
  const Json json = with(make_small_scene(), "/meshes/5/file/fetch", "bring it");
  const Json group = parse_json(R"({"name": "two", "group": [{"mesh": "ball"}, {"mesh": "scan"}]})", "test");
  const Scene scene = load_scene_of(folder, with(json, "/meshes/6", group));
  EXPECT_EQ(find_missing_file(scene, "pair"), "");
  for (const char* mesh : {"scan", "two"})
    EXPECT_THAT(find_missing_file(scene, mesh), HasSubstr("scan.obj; bring it")) << mesh;
  folder.write("scan.obj", "");
  EXPECT_EQ(find_missing_file(scene, "two"), "");
}

TEST(MakeObject, FromAFileIsFittedTurnedUprightAndStood) {
  const TempFolder folder;
  folder.write("scan.obj", "v 0 0 0\nv 2 0 0\nv 0 8 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  Json json = with(make_small_scene(), "/meshes/5/file/up", "y");
  json = with(json, "/meshes/5/file/radius", 0.5);
  const Scene scene = load_scene_of(folder, json);
  const TriangleMesh mesh = make_object(scene, "Scan");
  float lowest = 1e9f, highest = -1e9f;
  for (Vec3 p : mesh.positions) {
    lowest = std::min(lowest, p.z);
    highest = std::max(highest, p.z);
  }
  // The box is 2 x 2 x 8, tall upwards; its middle is sqrt(18) from each vertex, which becomes 0.5.
  EXPECT_NEAR(lowest, 0.75, 1e-6);
  EXPECT_NEAR(highest - lowest, 8 * 0.5 / std::sqrt(18.0), 1e-5);
  EXPECT_GT(volume_of(mesh), 0) << "turned, not mirrored";
}

TEST(PlaceMesh, TiltsThenTurnsThenScalesThenMovesAndTurnsNormals) {
  TriangleMesh mesh{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const TriangleMesh placed = place_mesh(mesh, {{10, 20, 30}, 90, 90, 2});
  // Tilted by 90 degrees about x, z goes to -y and y to z; turned by 90 degrees about z, -y goes to x and x
  // to y.
  expect_near(placed.normals[0], {1, 0, 0});
  expect_near(placed.normals[1], {0, 1, 0});
  expect_near(placed.normals[2], {0, 0, 1});
  expect_near(placed.positions[0], {12, 20, 30}, 1e-5f);
  expect_near(placed.positions[1], {10, 22, 30}, 1e-5f);
  expect_near(placed.positions[2], {10, 20, 32}, 1e-5f);
}

TEST(PlaceMesh, KeepsNormalsOnTheirFaces) {
  const TempFolder folder;
  const Scene scene = load_scene_of(folder, make_small_scene());
  const TriangleMesh ball = make_mesh(scene, "ball"), placed = place_mesh(ball, {{3, -2, 1}, 37, 71, 1.7f});
  EXPECT_NEAR(largest_normal_error(placed), largest_normal_error(ball), 0.01);
  EXPECT_NEAR(area_of(placed) / area_of(ball), 1.7 * 1.7, 1e-5);
}

TEST(MakeMesh, OfAGroupJoinsItsPlacedParts) {
  const TempFolder folder;
  const Scene scene = load_scene_of(folder, make_small_scene());
  EXPECT_NEAR(area_of(make_mesh(scene, "pair")),
              area_of(make_mesh(scene, "post")) + area_of(make_mesh(scene, "ball")), 1e-5);
}

TEST(MakeMesh, MakesEveryMeshOfTheCafeWithoutNaN) {
  const Scene scene = load_cafe();
  for (const auto& [name, spec] : scene.meshes) {
    if (spec.find("file")) continue;
    const TriangleMesh mesh = make_mesh(scene, name);
    EXPECT_FALSE(mesh.triangles.empty()) << name;
    for (Vec3 p : mesh.positions) ASSERT_TRUE(is_finite(p)) << name;
    for (Vec3 n : mesh.normals) ASSERT_NEAR(length(n), 1, 1e-5) << name;
  }
}

TEST(ViewCameras, AreFifteenDegreesApartAboutTheVerticalThroughTheStand) {
  const TempFolder folder;
  for (const Scene& scene : {load_cafe(), load_scene_of(folder, make_small_scene())}) {
    const Camera a = make_view_camera(scene, 0), b = make_view_camera(scene, 1);
    EXPECT_EQ(a.position, scene.camera.position);
    EXPECT_EQ(a.target, scene.camera.target);
    EXPECT_EQ(a.up, scene.camera.up);
    for (const auto& [from, to] : {std::pair{a.position - scene.stand, b.position - scene.stand},
                                   std::pair{a.target - a.position, b.target - b.position}}) {
      EXPECT_NEAR(from.z, to.z, 1e-6) << "the axis is vertical";
      EXPECT_NEAR(length(from), length(to), 1e-5);
      EXPECT_NEAR(angle_between({from.x, from.y, 0}, {to.x, to.y, 0}), 15, 1e-4);
      EXPECT_GT(from.x * to.y - from.y * to.x, 0) << "counter-clockwise from above";
    }
    EXPECT_EQ(a.vertical_fov_degrees, b.vertical_fov_degrees);
  }
}

// What a lathe of its axis, a quad without a side and a sphere beyond float come to is not a mesh, wherever
// used.
TEST(MakeMesh, WithoutAnAreaIsRefusedByName) {
  const TempFolder folder;
  const auto refusal = [&](const char* mesh) {
    const Json json = with(make_small_scene(), "/meshes/4", parse_json(mesh, "mesh"));
    const Scene scene = load_scene_of(folder, json);
    return message_of<InputError>([&] { make_mesh(scene, "pair"); });
  };
  const std::string name = R"("name": "pair", )";
  for (const std::string mesh :
       {R"("lathe": {"profile": [[0, 0], [0, 1]], "segments": 8}})",
        R"("quad": {"u": [1, 0, 0], "v": [2, 0, 0]}})", R"("sphere": {"radius": 1e-50, "subdivisions": 1}})"})
    EXPECT_THAT(refusal(("{" + name + mesh).c_str()),
                testing::HasSubstr("mesh \"pair\": expected a mesh with an area"));
  const std::string tiny = R"("scatter": {"mesh": "post", "over": "ball", "count": 2, "seed": 1}})";
  Json json = with(make_small_scene(), "/meshes/4", parse_json("{" + name + tiny, "mesh"));
  json = with(json, "/meshes/0/sphere/radius", 1e-25);
  EXPECT_EQ(make_mesh(load_scene_of(folder, json), "pair").triangles.size(),
            2 * make_mesh(load_scene_of(folder, json), "post").triangles.size());
}

}  // namespace
}  // namespace equilux
