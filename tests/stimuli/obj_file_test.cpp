// OBJ: every legal spelling of a shape gives that shape, and what is not read in full is refused with its
// line.
#include "stimuli/obj_file.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "base/error.h"
#include "base/random.h"
#include "tests/stimuli/mesh_measures.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// A corner of a cube, and vertices to which indices would slip if one before them were dropped.
constexpr const char* kFaces = "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
std::string corner_with(const std::string& side) {
  return fmt::format("v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nv 9 9 9\nv 8 8 7\nv 7 5 3\n{1}", side,
                     kFaces);
}

std::string replaced(std::string text, const std::string& part, const std::string& by) {
  for (std::size_t place = 0; (place = text.find(part, place)) != std::string::npos; place += by.size())
    text.replace(place, part.size(), by);
  return text;
}

TriangleMesh load_text(const std::string& text) {
  const TempFolder folder;
  return load_mesh(folder.write("a.obj", text));
}

void expect_same(const TriangleMesh& mesh, const TriangleMesh& expected) {
  EXPECT_EQ(mesh.positions, expected.positions);
  EXPECT_EQ(mesh.normals, expected.normals);
  EXPECT_EQ(mesh.triangles, expected.triangles);
}

void expect_refused(const std::string& text, const std::string& words) {
  const TempFolder folder;
  const auto path = folder.write("a.obj", text);
  EXPECT_THAT(message_of<InputError>([&] { load_mesh(path); }), StartsWith(path.string() + ": " + words))
      << text;
}

TEST(ObjFiles, OfAnySpellingOfANumberGiveTheSameShape) {
  const TriangleMesh expected = load_text(corner_with("0.4"));
  EXPECT_FLOAT_EQ(static_cast<float>(volume_of(expected)), .4f * .4f * .4f / 6);
  for (const char* side :
       {".4", "+0.4", "+.4", "00.4", "0.40", "4e-1", "4E-1", "4.e-1", ".04e1", "0.04e+1", ".4e0", ".4e-0",
        "0.40000000000000000000001", "400000000000000000000e-21", "0.000000000000000000004e20"}) {
    SCOPED_TRACE(side);
    expect_same(load_text(corner_with(side)), expected);
  }
  expect_same(load_text(corner_with("-.4")), load_text(corner_with("-0.4")));
  expect_same(load_text(corner_with("4.")), load_text(corner_with("4")));
}

TEST(ObjFiles, OfAnyLayoutOfLinesGiveTheSameShape) {
  const std::string plain = corner_with("0.4");
  const TriangleMesh expected = load_text(plain);
  for (const std::string& text :
       {replaced(plain, " ", "\t"), replaced(plain, " ", "   "), replaced(plain, "\n", "\r\n"),
        replaced(plain, "\n", " \t\n"), replaced(plain, "\n", "\n\n  "), replaced(plain, "\n", " # 5 6\n"),
        replaced(plain, "\n", "#\n"), replaced(plain, " ", " \\\n"), replaced(plain, " ", "\\\n "),
        replaced(plain, " ", " \\\r\n"), replaced(plain, " ", "\\\n\\\n "), plain.substr(0, plain.size() - 1),
        "\xef\xbb\xbf" + plain, "# C:\\meshes\\\n" + plain,
        "mtllib a#b\no \xc3\xa9\ng a b\ns off\nusemtl x\n" + plain, plain + "p 1\nl 1 2 3\n",
        replaced(plain, "f ", "fo ")}) {
    SCOPED_TRACE(text);
    expect_same(load_text(text), expected);
  }
}

TEST(ObjFiles, OfAnySpellingOfAFaceGiveTheSameShape) {
  const std::string plain = corner_with("0.4");
  const TriangleMesh expected = load_text(plain);
  const std::string vertices = plain.substr(0, plain.find('f'));
  for (const std::string& text :
       {vertices + "vt 0 0\nf 1/1 3/1 2/1\nf 1/ 2/ 4/\nf 1// 4// 3//\nf +2 +3 +4\n", kFaces + vertices,
        vertices + "f -7 -5 -6\nf -7 -6 -4\nf -7 -4 -5\nf -6 -5 -4\n",
        replaced(vertices, "\n", " 1\n") + kFaces, replaced(vertices, "\n", " .1 .2 .3\n") + kFaces}) {
    SCOPED_TRACE(text);
    expect_same(load_text(text), expected);
  }
}

TEST(ObjFiles, GiveEachCornerItsNormalAndTheOthersTheirFaces) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 2\nvn 0 3 4\n";
  for (const char* face : {"f 1//2 2//2 3//2\n", "f 1/1/2 2/1/2 3/1/2\n", "f 1//-1 2//-1 3/1/-1\n"}) {
    for (Vec3 normal : load_text(vertices + face).normals) {
      EXPECT_FLOAT_EQ(normal.y, .6f) << face;
      EXPECT_FLOAT_EQ(normal.z, .8f) << face;
    }
  }
  const TriangleMesh mixed = load_text(vertices + "f 1//2 2 3\n");
  EXPECT_FLOAT_EQ(mixed.normals[0].y, .6f);
  EXPECT_EQ(mixed.normals[1], (Vec3{0, 0, 1}));
}

TEST(ObjFiles, WithAVertexThatIsNoneAreRefusedWithItsLine) {
  const std::string number = "line 2: expected a finite number within float's range, got ";
  for (const char* side : {"nan", "inf", "-inf", "1e39", "1e999", "0x1", "0,4", "0.4f", "4d-1", "1e", "-",
                           "+", "--1", "+-1", "-+1", "1..2", ".", "x", "\\"})
    expect_refused(corner_with(side), number + '"' + side + '"');
  expect_refused("v 0 0 0\nv 1 0\n", number + "the end of the line");
  expect_refused("v 0 0 0\nv\n", number + "the end of the line");
  expect_refused("v 0 0 0\nv 1 0 0 .5 .5\n", number + "the end of the line");
  expect_refused("v 0 0 0\nv 1 0 0 .5 .5 .5 1\n",
                 "line 2: expected 3 coordinates, with a weight or a colour");
  expect_refused("v 0 0 0\nv 1 0 0 2\n", "line 2: expected a weight of 1, as polygons have it, got 2");
  expect_refused("\nvn 0 1\n", number + "the end of the line");
  expect_refused("\nvn 0 1 0 1\n", "line 2: expected 3 coordinates, got \"1\" more");
}

TEST(ObjFiles, WithAFaceThatIsNoneAreRefusedWithItsLine) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n";
  for (const char* corner : {"0", "x", "2.5", "1e0", "4294967298", "99999999999999999999", "/1", "//1",
                             "1//0", "1//x", "1/2/3/4", "1,2"})
    expect_refused(vertices + "f 1 2 " + corner + "\n",
                   "line 5: expected an index, from 1 or from -1 backwards, got ");
  expect_refused(vertices + "f 1 2/x 3\n", "line 5: expected an index of a texture coordinate, got \"2/x\"");
  expect_refused(vertices + "f 1 2 4\nv 1 1\n", "line 6: ");
  expect_refused(vertices + "f 1 2 4\nf 1 2 9\n", "line 5: expected vertices of the 3 in the file, got 4");
  expect_refused(vertices + "f 1 2 -4\nv 1 1 1\n",
                 "line 5: expected an index to one of the 3 before it, got \"-4\"");
  expect_refused(vertices + "f 1//1 2//1 3//2\n", "line 5: expected normals of the 1 in the file, got 2");
  expect_refused(vertices + "f 1//1 2//1 3//-2\n", "line 5: expected an index to one of the 1 before it");
  for (const auto& [face, corners] : {std::pair{"f\n", 0}, {"f 1\n", 1}, {"f 1 2\n", 2}, {"f 1 2 # 3\n", 2}})
    expect_refused(vertices + face,
                   fmt::format("line 5: expected at least 3 corners in a face, got {}", corners));
  expect_refused(vertices + "f" + replaced(std::string(4097, ' '), " ", " 1") + "\n",
                 "line 5: expected at most 4096 corners in a face, got more");
}

TEST(ObjFiles, WithLinesThatWouldBeLeftOutAreRefused) {
  for (const char* line :
       {"surf 0 1 0 1 1 2 3 4", "bzp 1 2 3", "call other.obj", "csh ls", "V 1 2 3", "w 1 2 3"})
    expect_refused(corner_with("1") + line + "\n", "line 12: expected v, vn, f or a statement of OBJ");
  expect_refused("v 0 0 \\\n0\nv 1 0 0 x", "line 3: ");
  expect_refused("v 0 0 0.\\\n4\n", "line 1: expected a blank where a backslash joins two lines");
  expect_refused("v 0 0 0 \\", "line 1: expected a line after the backslash, got the end of the file");
  expect_refused("v 0 0 0\n# old\rv 1 2 3\n", "line 2: expected text, got a control character");
  expect_refused(std::string("v 0 0 0\n\0v 1 2 3\n", 17), "line 2: expected text, got a control character");
}

std::string polygon_text(const std::vector<std::array<double, 2>>& corners, double tilt = 0) {
  std::string vertices, face = "f";
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto [x, y] = corners[i];
    vertices += fmt::format("v {} {} {}\n", x, y * std::cos(tilt), y * std::sin(tilt));
    face += fmt::format(" {}", i + 1);
  }
  return vertices + face + "\n";
}

double shoelace(const std::vector<std::array<double, 2>>& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return std::abs(twice) / 2;
}

TEST(ObjFiles, CutPolygonsOfNCornersIntoNMinusTwoTrianglesOfTheirArea) {
  for (std::size_t n : {4, 5, 7, 40}) {
    RandomStream random(17, "stars", n);
    for (int turn = 0; turn < 20; ++turn) {
      std::vector<std::array<double, 2>> star;
      for (std::size_t i = 0; i < n; ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        const double radius = .2 + random.next_double();
        star.push_back({radius * std::cos(angle), radius * std::sin(angle)});
      }
      if (turn % 2) std::reverse(star.begin(), star.end());
      const TriangleMesh mesh = load_text(polygon_text(star, .3 * turn));
      EXPECT_EQ(mesh.triangles.size(), n - 2);
      EXPECT_NEAR(area_of(mesh), shoelace(star), 1e-5) << "seed 17, n " << n << ", turn " << turn;
      const Vec3 up{0, static_cast<float>(-std::sin(.3 * turn)), static_cast<float>(std::cos(.3 * turn))};
      for (Vec3 normal : mesh.normals) EXPECT_NEAR(dot(normal, up), turn % 2 ? -1 : 1, 1e-4);
    }
  }
}

// assimp lost a third of its triangles.
TEST(ObjFiles, CutASpiralWhole) {
  std::vector<std::array<double, 2>> spiral, inner;
  for (int i = 0; i < 400; ++i) {
    const double angle = .05 * i;
    spiral.push_back({(1 + angle) * std::cos(angle), (1 + angle) * std::sin(angle)});
    inner.push_back({(.5 + angle) * std::cos(angle), (.5 + angle) * std::sin(angle)});
  }
  spiral.insert(spiral.end(), inner.rbegin(), inner.rend());
  const TriangleMesh mesh = load_text(polygon_text(spiral));
  EXPECT_EQ(mesh.triangles.size(), 798u);
  EXPECT_NEAR(area_of(mesh), shoelace(spiral), 1e-3);
}

TEST(ObjFiles, CutConvexPolygonsFromTheFirstCorner) {
  const TriangleMesh mesh = load_text("v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 0\nf 1 2 3 4\n");
  EXPECT_NEAR(volume_of(mesh), 0, 1e-9) << "the diagonal is 1 to 3, through the origin";
  EXPECT_NEAR(area_of(mesh), std::sqrt(2.0), 1e-6);
}

TEST(ObjFiles, CutPolygonsWithABridgeToTheirHole) {
  const TriangleMesh mesh = load_text(
      "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\nf 1 2 3 4 1 5 6 7 8 5\n");
  EXPECT_EQ(mesh.triangles.size(), 8u);
  EXPECT_NEAR(area_of(mesh), 12, 1e-6);
}

TEST(ObjFiles, CountWhatAPolygonHasOfDegenerateTriangles) {
  const TempFolder folder;
  MeshRepairs repairs;
  const TriangleMesh mesh = load_mesh(
      folder.write("a.obj",
                   "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .1 .3 .7\nv .2 .6 1.4\nv .4 1.2 2.8\nv .8 2.4 5.6\n"
                   "f 1 2 2 3 4\nf 5 6 7 8\nf 1 1 1 1\n"),
      &repairs);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_NEAR(area_of(mesh), 1, 1e-6);
  EXPECT_EQ(repairs.degenerate_triangles, 1u + 2 + 2);
}

TEST(ObjFiles, WithAPolygonThatCrossesItselfAreRefusedWithItsLine) {
  expect_refused("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3 4\n",
                 "line 6: expected a polygon that does not cross itself");
}

TEST(ObjFiles, AreKnownByTheirEndingOrTheirFirstStatement) {
  const TempFolder folder;
  const std::string text = "# a comment\r\n\n" + corner_with("1");
  for (const char* name : {"a.obj", "a.OBJ", "a.mesh", "a"}) {
    EXPECT_TRUE(is_obj(name, text)) << name;
    EXPECT_EQ(load_mesh(folder.write(name, text)).triangles.size(), 4u) << name;
  }
  for (const char* name : {"a.ply", "a.STL"}) EXPECT_FALSE(is_obj(name, text)) << name;
  for (const char* other : {"", "ply\n", "solid x\n", "no mesh at all"})
    EXPECT_FALSE(is_obj("a.mesh", other)) << other;
}

}  // namespace
}  // namespace equilux
