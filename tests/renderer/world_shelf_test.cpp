// One world at a time, each as it was.
#include "renderer/world_shelf.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class WorldShelfTest : public testing::Test {
 protected:
  WorldShelfTest() {
    write_mesh(1);
    save_text(folder_ / "scene.json",
              R"({"schema":"equilux-scene","schema_version":1,"name":"test",
        "camera":{"position":[0,-4,0],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":40},
        "materials":[{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]}],
        "meshes":[{"name":"read","file":{"path":"read.obj"}},
                  {"name":"ball","sphere":{"radius":1,"subdivisions":3}}],
        "instances":[],
        "object":{"stand":[0,0,-1],"geometries":[{"name":"G0","mesh":"read"},{"name":"G1","mesh":"ball"}]},
        "lights":[{"spot":{"position":[0,-4,0],"target":[0,0,0],"inner_degrees":20,"outer_degrees":40,
                           "intensity":[1,1,1]}}]})");
    scene_ = load_scene(folder_ / "scene.json");
  }
  void write_mesh(int height) const {
    save_text(folder_ / "read.obj", "v 0 0 0\nv 1 0 0\nv 0 0 " + std::to_string(height) + "\nf 1 2 3\n");
  }

  const test::Folder folder_;
  Scene scene_;
  double seconds_ = 0;
  const WorldKey read_{"G0"}, ball_{"G1"};
};

TEST_F(WorldShelfTest, KeepsTheLastWorldAlone) {
  WorldShelf worlds(scene_, seconds_);
  EXPECT_EQ(worlds.take(read_).triangle_count(), 1u);
  const double once = seconds_;
  EXPECT_GT(once, 0);
  worlds.take(read_);
  EXPECT_EQ(seconds_, once);
  EXPECT_EQ(worlds.take(ball_).triangle_count(), 20u * 4 * 4 * 4);
  EXPECT_EQ(worlds.take(read_).triangle_count(), 1u);
  EXPECT_GT(seconds_, once) << "made again";
}

TEST_F(WorldShelfTest, RefusesAWorldThatBecameAnother) {
  WorldShelf worlds(scene_, seconds_);
  worlds.take(read_);
  worlds.take(ball_);
  write_mesh(1);
  EXPECT_EQ(worlds.take(read_).triangle_count(), 1u) << "written anew, the same";
  worlds.take(ball_);
  write_mesh(2);
  EXPECT_THAT(message_of<InputError>([&] { worlds.take(read_); }),
              AllOf(HasSubstr("scene.json"), HasSubstr("other triangles in G0-ind than at the start")));
}

}  // namespace
}  // namespace equilux
