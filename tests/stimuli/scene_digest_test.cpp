// What a picture depends on: its digest changes with what is shown and with nothing else.
#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/stimuli/small_scene.h"
#include "tests/support/json_edit.h"

namespace equilux {
namespace {

const Object kIndirect{"G0", "MS", Illumination::kIndirect};
const Object kDirect{"G0", "MS", Illumination::kDirectAndIndirect};

class SceneDigest : public testing::Test {
 protected:
  std::string digest(const Json& json, const Object& object = kIndirect, bool with_material = true) {
    return digest_scene_part(load_scene_of(folder_, json), object, with_material);
  }
  void expect_same(const std::string& place, const Json& value, const Object& object = kIndirect) {
    EXPECT_EQ(digest(with(scene_, place, value), object), digest(scene_, object)) << place;
  }
  void expect_other(const std::string& place, const Json& value, const Object& object = kIndirect) {
    EXPECT_NE(digest(with(scene_, place, value), object), digest(scene_, object)) << place;
  }
  const TempFolder folder_;
  const Json scene_ = make_small_scene();
};

TEST_F(SceneDigest, IsBlindToWhatIsNotShown) {
  const Json more = with(scene_, "/materials/-", scene_.at("materials").at(std::size_t{1}));
  EXPECT_EQ(digest(with(more, "/materials/3/name", "unused")), digest(scene_));
  expect_same("/meshes/1/blob/seed", 2);
  expect_same("/meshes/5/file/path", "other.obj");
  expect_same("/object/geometries/1/mesh", "ground");
  expect_same("/name", "renamed");
  expect_same("/description", "described");
  EXPECT_EQ(digest(without(scene_, "/object/geometries/2")), digest(scene_));
}

TEST_F(SceneDigest, IsBlindToALightThatIsOff) {
  expect_same("/lights/1/rectangle/radiance/0", 9, kIndirect);
  expect_other("/lights/1/rectangle/radiance/0", 9, kDirect);
  EXPECT_NE(digest(scene_, kIndirect), digest(scene_, kDirect));
  EXPECT_EQ(digest(without(scene_, "/lights/1"), kIndirect), digest(scene_, kIndirect));
}

TEST_F(SceneDigest, ChangesWithEverythingThatIsShown) {
  expect_other("/camera/position/0", 0.1);
  expect_other("/camera/target/0", 0.2);
  expect_other("/camera/up/0", 0.1);
  expect_other("/camera/vertical_fov_degrees", 41);
  expect_other("/object/stand/2", 0.8);
  expect_other("/meshes/0/sphere/radius", 0.41);
  expect_other("/meshes/2/quad/u/0", 5);
  expect_other("/meshes/3/lathe/segments", 9);
  expect_other("/meshes/4/group/1/at/2", 1.1);
  expect_other("/instances/0/at/0", -2.5);
  expect_other("/instances/1/turn_degrees", 31);
  expect_other("/instances/1/material", "floor");
  expect_other("/materials/0/alpha", 0.06);
  expect_other("/materials/0/rho_s/1", 0.23);
  expect_other("/materials/0/model", "ward");
  expect_other("/materials/2/rho_d/0", 0.6);
  expect_other("/lights/0/spot/intensity/1", 11);
  expect_other("/lights/0/spot/inner_degrees", 11);
  expect_other("/lights/0/spot/target/0", 0.1);
}

TEST_F(SceneDigest, ChangesWithWhatAScatterIsMadeOf) {
  const Json scattered = with(scene_, "/meshes/4",
                              parse_json(R"({"name": "pair", "scatter":
      {"mesh": "post", "over": "ball", "count": 3, "seed": 1}})",
                                         "scatter"));
  const std::string whole = digest(scattered);
  EXPECT_NE(digest(with(scattered, "/meshes/4/scatter/count", 4)), whole);
  EXPECT_NE(digest(with(scattered, "/meshes/4/scatter/seed", 2)), whole);
  EXPECT_NE(digest(with(scattered, "/meshes/3/lathe/segments", 9)), whole);
  EXPECT_NE(digest(with(scattered, "/meshes/0/sphere/radius", 0.41)), whole);
}

TEST_F(SceneDigest, DiffersForGeometryAndMaterial) {
  EXPECT_NE(digest(scene_, {"G1", "MS", Illumination::kIndirect}), digest(scene_));
  EXPECT_NE(digest(scene_, {"G0", "LG", Illumination::kIndirect}), digest(scene_));
}

TEST_F(SceneDigest, WithoutTheMaterialIsBlindToItButNotToTheRoom) {
  const Json changed = with(scene_, "/materials/0/alpha", 0.06);
  EXPECT_EQ(digest(changed, kIndirect, false), digest(scene_, kIndirect, false));
  EXPECT_EQ(digest(scene_, {"G0", "LG", Illumination::kIndirect}, false), digest(scene_, kIndirect, false));
  EXPECT_NE(digest(with(scene_, "/materials/2/rho_d/0", 0.6), kIndirect, false),
            digest(scene_, kIndirect, false));
}

TEST_F(SceneDigest, IsTheSameHoweverNamesAndKeysAreOrdered) {
  Json moved = with(without(scene_, "/camera"), "/camera", scene_.at("camera"));
  const Json spot = scene_.at("lights").at(std::size_t{0}).at("spot");
  moved = with(moved, "/lights/0/spot", with(without(spot, "/position"), "/position", spot.at("position")));
  EXPECT_EQ(digest(moved), digest(scene_));
  Json renamed = with(with(scene_, "/materials/2/name", "parquet"), "/instances/0/material", "parquet");
  renamed = with(with(renamed, "/meshes/2/name", "slab"), "/instances/0/mesh", "slab");
  EXPECT_EQ(digest(renamed), digest(scene_));
}

TEST_F(SceneDigest, OfAMeshFileGoesWithItsBytes) {
  const Object scan{"Scan", "MS", Illumination::kIndirect};
  EXPECT_THROW(digest(scene_, scan), InputError);
  folder_.write("scan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string before = digest(scene_, scan);
  EXPECT_EQ(digest(scene_, scan), before);
  folder_.write("scan.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
  EXPECT_NE(digest(scene_, scan), before);
}

TEST_F(SceneDigest, OfAMeshFileThatWasReadNeedsTheFileNoMore) {
  folder_.write("scan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Scene scene = load_scene_of(folder_, scene_);
  const Object first{"Scan", "MS", Illumination::kIndirect}, second{"Scan", "LG", Illumination::kIndirect};
  const std::string one = digest_scene_part(scene, first), other = digest_scene_part(scene, second);
  MeshDigests digests;
  EXPECT_EQ(digest_scene_part(scene, first, true, &digests), one);
  folder_.write("scan.obj", "");
  EXPECT_EQ(digest_scene_part(scene, second, true, &digests), other);
  EXPECT_THROW(digest_scene_part(scene, second), InputError);
}

}  // namespace
}  // namespace equilux
