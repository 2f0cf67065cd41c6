// The script that brings the scanned meshes, with an npm of our own: what it makes loads, what it finds wrong
// it says, and it leaves nothing half made. The real packages are not part of a test.
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.h"
#include "stimuli/mesh.h"
#include "tests/experiment/fake_study.h"
#include "tests/walk/programs.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::HasSubstr;

constexpr const char* kTetrahedron =
    "exports.positions=[[0,0,0],[1,0,0],[0,1,0],[0,0,1.5e0]]\n"
    "exports.cells=[[0,2,1],[0,1,3],[0,3,2],[1,2,3]]\n";
constexpr const char* kDragonPly =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
    "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

class FetchMeshes : public ::testing::Test {
 protected:
  FetchMeshes() {
    fs::create_directories(bin_);
    // "npm pack --silent --ignore-scripts NAME@VERSION" with archives made here.
    save_text(bin_ / "npm", R"(#!/bin/sh
set -e
for last; do :; done
name=${last%@*} version=${last#*@}
[ ! -e ")" + (temporary_.path() / "offline").string() +
                                R"(" ] || exit 1
mkdir -p package/models
cp ")" + (temporary_.path() / "index.js").string() +
                                R"(" package/index.js
gzip -c ")" + (temporary_.path() / "dragon.ply").string() +
                                R"(" >package/models/dragon_vrip_res2.ply.gz
tar -czf "$name-$version.tgz" package
)");
    fs::permissions(bin_ / "npm", fs::perms::owner_all);
    save_text(temporary_.path() / "index.js", kTetrahedron);
    save_text(temporary_.path() / "dragon.ply", kDragonPly);
  }

  ChildResult fetch() {
    return Child("/usr/bin/env", {"PATH=" + bin_.string() + ":/usr/local/bin:/usr/bin:/bin", "bash",
                                  EQUILUX_SOURCE_DIR "/stimuli/meshes/fetch.sh", out_.string()})
        .wait();
  }

  TemporaryFolder temporary_;
  fs::path bin_ = temporary_.path() / "bin", out_ = temporary_.path() / "meshes";
};

TEST_F(FetchMeshes, BringsBothMeshesAndCreditsTheirMakers) {
  const ChildResult result = fetch();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("Stanford Computer Graphics Laboratory"));
  EXPECT_EQ(load_mesh(out_ / "bunny.ply").triangles.size(), 4u);
  EXPECT_EQ(load_text(out_ / "dragon.ply"), kDragonPly);
}

TEST_F(FetchMeshes, LeavesWhatIsThere) {
  fs::create_directories(out_);
  save_text(out_ / "bunny.ply", "mine");
  EXPECT_EQ(fetch().exit_code, 0);
  EXPECT_EQ(load_text(out_ / "bunny.ply"), "mine");
  EXPECT_TRUE(fs::exists(out_ / "dragon.ply"));
}

TEST_F(FetchMeshes, SaysWhatIsWrongAndLeavesNothingHalfMade) {
  save_text(temporary_.path() / "index.js", "exports.positions=[[0,0,0]]\nexports.cells=[[0,0,7]]\n");
  const ChildResult bad = fetch();
  EXPECT_NE(bad.exit_code, 0);
  EXPECT_THAT(bad.err, HasSubstr("cell 0: expected three indices under 1, got [0, 0, 7]"));
  EXPECT_FALSE(fs::exists(out_ / "bunny.ply"));
  save_text(temporary_.path() / "offline", "");
  const ChildResult offline = fetch();
  EXPECT_NE(offline.exit_code, 0);
  EXPECT_THAT(offline.err, HasSubstr("npm could not bring bunny@1.0.1"));
}

}  // namespace
}  // namespace equilux
