// Meshes from files that users bring: three formats, what is mended and what is refused.
#include <gtest/gtest.h>

#include "base/error.h"
#include "stimuli/mesh.h"
#include "tests/stimuli/mesh_measures.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// The corner of the unit cube: volume 1/6, area 3/2 + sqrt(3)/2.
constexpr const char* kObj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
constexpr const char* kPly =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
constexpr const char* kStl =
    "solid corner\n"
    "facet normal 0 0 -1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
    "facet normal 0 -1 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\n"
    "facet normal -1 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 0 1 0\nendloop\nendfacet\n"
    "facet normal 0.577 0.577 0.577\nouter loop\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 0 "
    "1\nendloop\nendfacet\n"
    "endsolid corner\n";

std::string ply_with(std::string_view part, const std::string& replacement) {
  const std::string text = kPly;
  const std::size_t place = text.find(part);
  return text.substr(0, place) + replacement + text.substr(place + part.size());
}

void expect_refused(const std::filesystem::path& path, const char* words = "") {
  EXPECT_THAT(message_of<InputError>([&] { load_mesh(path); }),
              AllOf(StartsWith(path.string() + ": "), HasSubstr(words)));
}

TEST(MeshFiles, OfThreeFormatsGiveTheSameShape) {
  const TempFolder folder;
  for (const auto& [name, text] : {std::pair{"a.obj", kObj}, {"a.ply", kPly}, {"a.stl", kStl}}) {
    MeshRepairs repairs;
    const TriangleMesh mesh = load_mesh(folder.write(name, text), &repairs);
    EXPECT_EQ(mesh.triangles.size(), 4u) << name;
    EXPECT_NEAR(volume_of(mesh), 1.0 / 6, 1e-6) << name;
    EXPECT_NEAR(area_of(mesh), 1.5 + std::sqrt(3.0) / 2, 1e-6) << name;
    EXPECT_EQ(mesh.normals.size(), mesh.positions.size()) << name;
    EXPECT_EQ(repairs.degenerate_triangles, 0u) << name;
  }
}

TEST(MeshFiles, OfPolygonsAndPartsAreJoinedAsTriangles) {
  const TempFolder folder;
  const auto path = folder.write("a.obj",
                                 "o one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
                                 "o two\nv 0 0 5\nv 2 0 5\nv 2 2 5\nv 0 2 5\nf 5 6 7 8\n");
  const TriangleMesh mesh = load_mesh(path);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_NEAR(area_of(mesh), 5, 1e-6);
  for (Vec3 normal : mesh.normals) EXPECT_NEAR(normal.z, 1, 1e-6);
}

// Coordinates that floats do not hold exactly: a rounded cross product of such a face need not be zero.
TEST(MeshFiles, WithDegenerateFacesLeaveThemOutAndCountThem) {
  const TempFolder folder;
  const auto path =
      folder.write("a.ply",
                   "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n"
                   "0.1 0.37 0.73\n1.13 0.21 0.3\n0.17 1.9 0.7\n0.3 0.7 1.1\n0.6 1.4 2.2\n0.9 2.1 3.3\n"
                   "3 0 1 2\n3 0 1 1\n3 2 0 2\n3 3 3 3\n");
  MeshRepairs repairs;
  const TriangleMesh mesh = load_mesh(path, &repairs);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(repairs.degenerate_triangles, 3u);
}

TEST(MeshFiles, WithAVertexOfDegenerateFacesAloneLeaveItOut) {
  const TempFolder folder;
  const auto path = folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 -9\nf 1 2 3\nf 4 4 1\n");
  const TriangleMesh mesh = load_mesh(path);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  for (Vec3 p : mesh.positions) EXPECT_EQ(p.z, 0) << "or the object would hang above its stand";
}

TEST(MeshFiles, WithThreeCornersInALineLeaveThemOut) {
  const TempFolder folder;
  const auto path =
      folder.write("a.obj", "v 0.1 0.3 0.7\nv 0.2 0.6 1.4\nv 0.4 1.2 2.8\nv 5 0 0\nf 1 2 3\nf 1 2 4\n");
  MeshRepairs repairs;
  EXPECT_EQ(load_mesh(path, &repairs).triangles.size(), 1u);
  EXPECT_EQ(repairs.degenerate_triangles, 1u);
}

TEST(MeshFiles, WithCoordinatesThatAreNotFiniteAreRefused) {
  const TempFolder folder;
  for (const char* bad : {"nan", "inf", "-inf"}) {
    expect_refused(folder.write("a.ply", ply_with("1 0 0\n0 1", std::string(bad) + " 0 0\n0 1")),
                   "finite coordinates");
  }
}

TEST(MeshFiles, WithoutTrianglesAreRefused) {
  const TempFolder folder;
  expect_refused(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"));
  expect_refused(folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n"));
  expect_refused(folder.write("c.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2\n"));
}

TEST(MeshFiles, ThatAreDamagedOrOfNoKindAreRefused) {
  const TempFolder folder;
  expect_refused(folder.write("a.ply", std::string_view(kPly).substr(0, 60)));
  expect_refused(folder.write("b.ply", "no mesh at all"));
  expect_refused(folder.write("a.unknown", "no mesh at all"));
  expect_refused(folder.write("empty.obj", ""));
}

TEST(MeshFiles, WithAFaceOfAVertexThatIsNotThereAreRefused) {
  const TempFolder folder;
  expect_refused(folder.write("a.ply", ply_with("3 1 2 3", "3 1 2 9")), "indices under 4, got 9");
}

TEST(MeshFiles, ThatAreMissingOrAFolderAreNamed) {
  const TempFolder folder;
  expect_refused(folder / "missing.obj");
  expect_refused(folder.path());
}

TEST(AppendMesh, KeepsAreaAndMakesFlatNormalsWhereOneHasNone) {
  TriangleMesh smooth{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, {{0, 1, 2}}};
  const TriangleMesh bare{{{0, 0, 2}, {2, 0, 2}, {0, 2, 2}}, {}, {{0, 2, 1}}};
  TriangleMesh one = smooth, other = bare;
  append_mesh(one, bare);
  append_mesh(other, smooth);
  for (const TriangleMesh& mesh : {one, other}) {
    EXPECT_DOUBLE_EQ(area_of(mesh), 2.5);
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  }
  EXPECT_EQ(one.normals[3], (Vec3{0, 0, -1}));
  EXPECT_EQ(other.normals[0], (Vec3{0, 0, -1}));
}

TEST(AppendMesh, OfNothingOrToNothingGivesTheOther) {
  const TriangleMesh bare{{{0, 0, 2}, {2, 0, 2}, {0, 2, 2}}, {}, {{0, 2, 1}}};
  TriangleMesh nothing, something = bare;
  append_mesh(nothing, bare);
  EXPECT_EQ(nothing.triangles, bare.triangles);
  append_mesh(something, TriangleMesh{});
  EXPECT_EQ(something.positions, bare.positions);
}

}  // namespace
}  // namespace equilux
