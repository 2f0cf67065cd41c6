// Meshes from files that users bring: three formats, what is mended and what is refused.
#include <bit>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "base/error.h"
#include "stimuli/generators.h"
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

TEST(MeshFiles, OfPlyWithCountsThatTheirBytesCannotKeepAreRefusedBeforeMemoryIsTaken) {
  const TempFolder folder;
  for (const char* count : {"4294967295", "1000000", "99999999999999999999999999", "-1"}) {
    expect_refused(folder.write("a.ply", ply_with("vertex 4", std::string("vertex ") + count)),
                   "line 3: expected at most as many elements as the file has bytes");
    expect_refused(folder.write("a.ply", ply_with("face 4", std::string("face ") + count)),
                   "line 7: expected at most as many elements as the file has bytes");
  }
  for (const char* list : {"4294967295 1 2 3", "4 1 2 3", "-3 1 2 3", "x 1 2 3"})
    expect_refused(folder.write("a.ply", ply_with("3 1 2 3", list)),
                   "line 17: expected a list that is as long");
  expect_refused(folder.write("a.ply", ply_with("3 1 2 3", "2 1 2 3")), "line 17: expected 3 values, got 4");
  expect_refused(folder.write("a.ply", ply_with("3 1 2 3\n", "")), "line 17: expected a line with all");
  for (const char* name : {"list-of-4-billion", "4-billion-vertices"}) {
    const std::string file = std::string(EQUILUX_SOURCE_DIR "/tests/fuzz/corpus/mesh/ply-binary-") + name;
    expect_refused(folder.write("a.ply", read_bytes(file).substr(1)));
  }
}

TEST(MeshFiles, OfPlyWithWhatOtherProgramsAddGiveTheSameShape) {
  const TempFolder folder;
  const TriangleMesh expected = load_mesh(folder.write("a.ply", kPly));
  const auto wider = [&](const std::string& properties, const std::string& values) {
    std::string text = ply_with("property float z\n", "property float z\n" + properties);
    for (const char* vertex : {"\n0 0 0", "\n1 0 0", "\n0 1 0", "\n0 0 1"})
      text.replace(text.find(vertex), 6, vertex + values);
    return text;
  };
  const std::string doubles = "property double x\nproperty float64 y\nproperty float32 z\n";
  for (const std::string& text :
       {wider("property uchar red\nproperty uchar green\nproperty uchar blue\n", " 255 0 +7"),
        wider("property float confidence\nproperty double quality\n", " .5 nan"),
        wider("property list uchar int neighbours\n", " 2 3 1"),
        ply_with("property float x\nproperty float y\nproperty float z\n", doubles),
        ply_with("vertex_indices", "vertex_index"), ply_with("uchar int", "int uint"),
        ply_with("\n1 0 0\n0 1", "\n1. -0.0 0e5\n.0 +1E0"),
        ply_with("end_header", "element edge 0\nproperty int vertex1\nend_header")}) {
    const TriangleMesh mesh = load_mesh(folder.write("a.ply", text));
    EXPECT_EQ(mesh.positions, expected.positions) << text;
    EXPECT_EQ(mesh.triangles, expected.triangles) << text;
  }
}

// Each of them has a shape, but another than would be read.
TEST(MeshFiles, OfPlyThatWouldBeReadAsAnotherShapeAreRefused) {
  const TempFolder folder;
  const auto expect = [&](const std::string& text, const char* words) {
    expect_refused(folder.write("a.ply", text), words);
  };
  for (const char* word : {"5.0", "1e0", "a", "-", "4294967298", "18446744073709551618", "-2147483649"})
    expect(ply_with("3 1 2 3", std::string("3 1 2 ") + word), "line 17: expected a value of type int");
  for (const char* word : {"1,5", "1.2.3", "1e5.5", "0x1", "1d0", "--1", "1e", "."})
    expect(ply_with("\n1 0 0", std::string("\n") + word + " 0 0"), "line 11: expected a value of type float");
  expect(ply_with("element vertex", "element camera 1\nproperty float x\nelement vertex"),
         "line 11: expected vertex as the first element, once, got the element camera");
  expect(ply_with("face", "vertex"), "expected vertex as the first element, once");
  expect(ply_with("element face", "element edge 0\nproperty int a\nelement edge 0\nelement face"),
         "expected each element once, got edge again");
  expect(ply_with("face 4\nproperty list uchar int vertex_indices",
                  "tristrips 1\nproperty list int int vertex_indices"),
         "expected surfaces as faces, got tristrips");
  expect(ply_with("float z", "float w"), "expected one property z of vertex, got none");
  expect(ply_with("float z", "float x"), "expected one property x of vertex, got more");
  expect(ply_with("vertex_indices", "corners"),
         "expected one property vertex_indices or vertex_index of face");
  expect(ply_with("uchar int", "uchar float"), "expected a list of integers as corners of face");
  expect(ply_with("ply\n", "\xef\xbb\xbfply\n"), "expected a PLY file, which begins with ply");
}

TEST(MeshFiles, OfPlyMayHaveCommentsBlanksAndLineEndsOfWindows) {
  const TempFolder folder;
  std::string text = ply_with("element vertex", "comment by hand\nobj_info none\nelement vertex");
  for (std::size_t place = 0; (place = text.find('\n', place)) != std::string::npos; place += 3)
    text.replace(place, 1, " \r\n");
  EXPECT_EQ(load_mesh(folder.write("a.ply", text)).triangles.size(), 4u);
}

// What it would wait for or read is not a part of the mesh.
TEST(MeshFiles, WithTooManyTrianglesAtOnePointAreRefusedBeforeAllPairsAreLookedAt) {
  const TempFolder folder;
  std::string text = "v 0 0 1\n";
  for (int i = 0; i <= 20001; ++i) text += fmt::format("v {} {} 0\n", std::cos(i * 3e-4), std::sin(i * 3e-4));
  for (int i = 0; i <= 20000; ++i) text += fmt::format("f 1 {} {}\n", i + 2, i + 3);
  expect_refused(folder.write("a.obj", text),
                 "expected at most 400000000 pairs of triangles that meet in a point, got 400120003");
}

TEST(MeshFiles, OpenNoPipesAndNothingOutsideTheirFolder) {
  const TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const char* library : {"pipe", "../a.mtl", "/dev/zero", "a.mtl"})
    EXPECT_EQ(load_mesh(folder.write("a.obj", fmt::format("mtllib {}\n{}", library, kObj))).triangles.size(),
              4u);
  constexpr const char* kGltf =
      R"({{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"{}","byteLength":36}}],"bufferViews":[{{"buffer":0,"byteLength":36}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],"nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}],"scene":0}})";
  const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::string bytes(reinterpret_cast<const char*>(corners), sizeof corners);
  folder.write("in/a.bin", bytes);
  folder.write("out.bin", bytes);
  expect_refused(folder.write("in/a.gltf", fmt::format(kGltf, "a.bin")), "a mesh in OBJ, PLY or STL");
}

// Of a triangle, its list counted in a type and in an order of bytes.
std::string make_binary_ply(const std::string& type, std::size_t bytes, std::int64_t count, bool big) {
  const auto number = [&](std::uint64_t value, std::size_t size) {
    std::string text;
    for (std::size_t i = 0; i < size; ++i)
      text += static_cast<char>(value >> 8 * (big ? size - 1 - i : i) & 0xff);
    return text;
  };
  std::string text = fmt::format(
      "ply\nformat binary_{}_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float "
      "z\nelement face 1\nproperty list {} int vertex_indices\nend_header\n",
      big ? "big" : "little", type);
  for (const float value : {0, 0, 0, 1, 0, 0, 0, 1, 0})
    text += number(std::bit_cast<std::uint32_t>(value), 4);
  text += number(static_cast<std::uint64_t>(count), bytes);
  for (const std::uint64_t index : {0, 1, 2}) text += number(index, 4);
  return text;
}

TEST(MeshFiles, OfBinaryPlyMayCountListsInAnyIntegerThatIsNoSignedByte) {
  const TempFolder folder;
  const std::vector<std::pair<std::string, std::size_t>> types{{"uchar", 1},  {"uint8", 1}, {"short", 2},
                                                               {"ushort", 2}, {"int", 4},   {"uint32", 4}};
  for (const auto& [type, bytes] : types) {
    for (const bool big : {false, true}) {
      EXPECT_EQ(load_mesh(folder.write("a.ply", make_binary_ply(type, bytes, 3, big))).triangles.size(), 1u)
          << type;
      expect_refused(folder.write("a.ply", make_binary_ply(type, bytes, -1, big)),
                     "as much as the header says");
      expect_refused(folder.write("a.ply", make_binary_ply(type, bytes, 4, big)),
                     "as much as the header says");
    }
  }
  expect_refused(folder.write("a.ply", make_binary_ply("char", 1, 3, false)),
                 "lists that are counted in uchar");
  expect_refused(folder.write("a.ply", make_binary_ply("long", 8, 3, false)), "types such as uchar");
  const std::string whole = make_binary_ply("uchar", 1, 3, false);
  for (std::size_t cut = 1; cut <= 13 + 36; ++cut)
    expect_refused(folder.write("a.ply", whole.substr(0, whole.size() - cut)), "as much as the header says");
}

TEST(MeshFiles, WithAnEmptyFaceAreRefused) {
  const TempFolder folder;
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
      "end_header\n0 0 0\n1 0 0\n0 1 0\n";
  expect_refused(folder.write("a.ply", head + "3 0 1 2\n0\n"), "face 1: expected at least one corner");
  EXPECT_EQ(load_mesh(folder.write("b.ply", head + "3 0 1 2\n\n3 0 2 1\n")).triangles.size(), 1u)
      << "a blank line is no face; the second is the first again";
}

TEST(MeshFiles, ThatAreMissingOrOfAnotherKindAreNamed) {
  const TempFolder folder;
  expect_refused(folder / "missing.obj", "No such file or directory");
  expect_refused(folder.path(), "expected a file, got a folder");
  std::filesystem::create_symlink("/dev/zero", folder / "endless.stl");
  expect_refused(folder / "endless.stl", "expected a regular file, got another kind");
}

// The memory of this process is a file whose first page cannot be read; of a mesh whose disk fails half-way
// nothing is taken for the whole either.
TEST(MeshFiles, ThatCannotBeReadAreNotTakenForShorterOnes) {
  const TempFolder folder;
  for (const char* name : {"a.obj", "a.ply", "a.stl", "a.mesh"}) {
    std::filesystem::create_symlink("/proc/self/mem", folder / name);
    expect_refused(folder / name, "expected a readable file, got Input/output error");
  }
}

// A cube of side 2 about the origin in twelve triangles, given corner by corner.
std::vector<std::array<Vec3, 3>> cube_soup() {
  const auto corner = [](int i) {
    return Vec3{i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f};
  };
  std::vector<std::array<Vec3, 3>> soup;
  for (const auto& [a, b, c, d] :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    soup.push_back({corner(a), corner(b), corner(c)});
    soup.push_back({corner(a), corner(c), corner(d)});
  }
  return soup;
}

std::string soup_as_ply(const std::vector<std::array<Vec3, 3>>& soup) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      3 * soup.size(), soup.size());
  for (const auto& triangle : soup) {
    for (Vec3 p : triangle) text += fmt::format("{} {} {}\n", p.x, p.y, p.z);
  }
  for (std::size_t i = 0; i < soup.size(); ++i)
    text += fmt::format("3 {} {} {}\n", 3 * i, 3 * i + 1, 3 * i + 2);
  return text;
}

std::string soup_as_obj(const std::vector<std::array<Vec3, 3>>& soup) {
  std::string vertices, faces;
  for (std::size_t i = 0; i < soup.size(); ++i) {
    for (Vec3 p : soup[i]) vertices += fmt::format("v {} {} {}\n", p.x, p.y, p.z);
    faces += fmt::format("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
  }
  return vertices + faces;
}

std::string soup_as_stl(const std::vector<std::array<Vec3, 3>>& soup) {
  std::string text = "solid soup\n";
  for (const auto& triangle : soup) {
    const Vec3 n = normalize(cross(triangle[1] - triangle[0], triangle[2] - triangle[0]));
    text += fmt::format("facet normal {} {} {}\nouter loop\n", n.x, n.y, n.z);
    for (Vec3 p : triangle) text += fmt::format("vertex {} {} {}\n", p.x, p.y, p.z);
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid soup\n";
}

TriangleMesh load_text_mesh(const std::string& name, const std::string& text, MeshRepairs& repairs) {
  const TempFolder folder;
  return load_mesh(folder.write(name, text), &repairs);
}

void expect_repairs(const MeshRepairs& found, const MeshRepairs& expected) {
  EXPECT_EQ(found.duplicate_vertices, expected.duplicate_vertices);
  EXPECT_EQ(found.degenerate_triangles, expected.degenerate_triangles);
  EXPECT_EQ(found.duplicate_triangles, expected.duplicate_triangles);
  EXPECT_EQ(found.non_manifold_edges, expected.non_manifold_edges);
  EXPECT_EQ(found.non_manifold_vertices, expected.non_manifold_vertices);
  EXPECT_EQ(found.open_edges, expected.open_edges);
}

TEST(MeshRepairs, OfASoupJoinItsCornersAndLeaveItClosedWithSharpEdges) {
  const auto soup = cube_soup();
  for (const auto& [name, text] :
       {std::pair{"a.ply", soup_as_ply(soup)}, {"a.obj", soup_as_obj(soup)}, {"a.stl", soup_as_stl(soup)}}) {
    SCOPED_TRACE(name);
    MeshRepairs repairs;
    const TriangleMesh mesh = load_text_mesh(name, text, repairs);
    expect_repairs(repairs, {.duplicate_vertices = 36 - 8});
    EXPECT_EQ(mesh.positions.size(), 24u) << "eight corners with three normals each";
    EXPECT_NEAR(volume_of(mesh), 8, 1e-6);
    EXPECT_LT(largest_normal_error(mesh), 1e-3) << "that of the faces";
  }
}

// Faces of a finely divided sphere bend by little: the soup of it must shine like the sphere itself.
TEST(MeshRepairs, MakeNormalsSmoothAcrossJoinedVertices) {
  const TriangleMesh sphere = make_sphere(1, 3);
  std::vector<std::array<Vec3, 3>> soup;
  for (const auto& [a, b, c] : sphere.triangles)
    soup.push_back({sphere.positions[a], sphere.positions[b], sphere.positions[c]});
  for (const auto& [name, text] :
       {std::pair{"a.ply", soup_as_ply(soup)}, {"a.obj", soup_as_obj(soup)}, {"a.stl", soup_as_stl(soup)}}) {
    SCOPED_TRACE(name);
    MeshRepairs repairs;
    const TriangleMesh mesh = load_text_mesh(name, text, repairs);
    expect_repairs(repairs, {.duplicate_vertices = 3 * soup.size() - sphere.positions.size()});
    ASSERT_EQ(mesh.positions.size(), sphere.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
      EXPECT_LT(angle_between(to_double(mesh.positions[i]), to_double(mesh.normals[i])), .3);
  }
}

TEST(MeshRepairs, OfTheThreeFormatsFindNothingInASoundMesh) {
  for (const auto& [name, text] : {std::pair{"a.obj", kObj}, {"a.ply", kPly}}) {
    MeshRepairs repairs;
    load_text_mesh(name, text, repairs);
    expect_repairs(repairs, {});
  }
  MeshRepairs repairs;
  load_text_mesh("a.stl", kStl, repairs);
  expect_repairs(repairs, {.duplicate_vertices = 8});
}

// Two pyramids, flat enough for smooth normals, that meet at their tops: joined there, they would cancel.
TEST(MeshRepairs, SplitABowTieWhereItsTwoFansMeet) {
  MeshRepairs repairs;
  const TriangleMesh mesh =
      load_text_mesh("a.obj",
                     "v 0 0 0\nv 2 0 1\nv -1 2 1\nv -1 -2 1\nv 2 0 -1\nv -1 2 -1\nv -1 -2 -1\n"
                     "f 1 3 2\nf 1 4 3\nf 1 2 4\nf 2 3 4\nf 1 5 6\nf 1 6 7\nf 1 7 5\nf 5 7 6\n",
                     repairs);
  expect_repairs(repairs, {.non_manifold_vertices = 1});
  EXPECT_EQ(mesh.triangles.size(), 8u);
  std::vector<float> tops;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_NEAR(length(mesh.normals[i]), 1, 1e-6);
    if (mesh.positions[i] == Vec3{}) tops.push_back(mesh.normals[i].z);
  }
  EXPECT_THAT(tops, testing::UnorderedElementsAre(testing::FloatNear(-1, .01f), testing::FloatNear(1, .01f)));
}

// Two sheets that meet in one vertex at sixty degrees: by the angle alone they would be smooth there.
TEST(MeshRepairs, SmoothNoNormalsFromFanToFan) {
  MeshRepairs repairs;
  const TriangleMesh mesh = load_text_mesh(
      "a.obj", "v 0 0 0\nv 1 1 0\nv -1 1 0\nv -1 -1 1.73205\nv 1 -1 1.73205\nf 1 2 3\nf 1 4 5\n", repairs);
  expect_repairs(repairs, {.non_manifold_vertices = 1, .open_edges = 6});
  EXPECT_EQ(mesh.positions.size(), 6u);
  EXPECT_LT(largest_normal_error(mesh), 1e-3);
}

TEST(MeshRepairs, OfTwoTetrahedraAtOneVertexCountIt) {
  MeshRepairs repairs;
  const TriangleMesh mesh = load_text_mesh("a.obj",
                                           std::string(kObj) +
                                               "v -1 0 0\nv 0 -1 0\nv 0 0 -1\n"
                                               "f 1 5 6\nf 1 7 5\nf 1 6 7\nf 5 7 6\n",
                                           repairs);
  expect_repairs(repairs, {.non_manifold_vertices = 1});
  EXPECT_EQ(mesh.triangles.size(), 8u);
}

TEST(MeshRepairs, OfThreeTrianglesOnAnEdgeKeepThem) {
  MeshRepairs repairs;
  const TriangleMesh mesh = load_text_mesh(
      "a.obj", "v 0 0 0\nv 0 0 1\nv 1 0 0\nv -1 1 0\nv -1 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n", repairs);
  expect_repairs(repairs, {.non_manifold_edges = 1, .open_edges = 6});
  EXPECT_EQ(mesh.triangles.size(), 3u);
  for (Vec3 normal : mesh.normals) EXPECT_NEAR(length(normal), 1, 1e-6);
}

TEST(MeshRepairs, LeaveOutATriangleGivenTwiceInAnyOrder) {
  MeshRepairs repairs;
  const TriangleMesh mesh = load_text_mesh("a.obj", std::string(kObj) + "f 3 2 1\nf 1 2 3\n", repairs);
  expect_repairs(repairs, {.duplicate_triangles = 2});
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_NEAR(volume_of(mesh), 1.0 / 6, 1e-6);
}

TEST(MeshRepairs, CountTheEdgesOfHoles) {
  auto soup = cube_soup();
  soup.pop_back();
  MeshRepairs repairs;
  load_text_mesh("a.ply", soup_as_ply(soup), repairs);
  expect_repairs(repairs, {.duplicate_vertices = 33 - 8, .open_edges = 3});
}

TEST(MeshRepairs, KeepTheNormalsOfTheFileWhereItHasThem) {
  MeshRepairs repairs;
  const TriangleMesh mesh = load_text_mesh(
      "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0.6 0.8\nvn 0 0 0\nf 1//1 2//1 3//2\n", repairs);
  ASSERT_EQ(mesh.normals.size(), 3u);
  EXPECT_LT(length(mesh.normals[0] - Vec3{0, .6f, .8f}), 1e-6f);
  EXPECT_EQ(mesh.normals[2], (Vec3{0, 0, 1})) << "the face's, for one of no length";
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
