// Generated shapes against closed forms: areas, volumes, normals, and that surfaces close and look outwards.
#include "stimuli/generators.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/stimuli/mesh_measures.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

constexpr double kPi = std::numbers::pi;

// Degrees by which a face may look away from the normals at its corners.
void expect_faces_along_normals(const TriangleMesh& mesh, double degrees) {
  for (const auto& triangle : mesh.triangles) {
    for (std::uint32_t vertex : triangle)
      ASSERT_LT(angle_between(face_vector(mesh, triangle), to_double(mesh.normals[vertex])), degrees);
  }
}

TEST(Sphere, HasItsVerticesAtTheRadiusWithExactNormals) {
  const TriangleMesh mesh = make_sphere(0.45f, 4);
  EXPECT_EQ(mesh.positions.size(), 10u * 256 + 2);
  EXPECT_EQ(mesh.triangles.size(), 20u * 256);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    EXPECT_NEAR(length(mesh.positions[i]), 0.45, 2e-7);
    EXPECT_LT(angle_between(to_double(mesh.positions[i]), to_double(mesh.normals[i])), 1e-4);
  }
  EXPECT_TRUE(is_closed(mesh));
}

// An inscribed polyhedron falls short of 4 pi r^2 and 4/3 pi r^3 by a share that goes with the edge squared:
// a quarter at each subdivision.
TEST(Sphere, ConvergesToAreaAndVolumeOfTheClosedForms) {
  const double r = 2, area = 4 * kPi * r * r, volume = 4 * kPi * r * r * r / 3;
  double area_error = 0, volume_error = 0;
  for (int subdivisions = 2; subdivisions <= 5; ++subdivisions) {
    const TriangleMesh mesh = make_sphere(static_cast<float>(r), subdivisions);
    const double new_area_error = area - area_of(mesh), new_volume_error = volume - volume_of(mesh);
    EXPECT_GT(new_area_error, 0);
    if (subdivisions > 2) {
      EXPECT_NEAR(area_error / new_area_error, 4, 0.15) << subdivisions;
      EXPECT_NEAR(volume_error / new_volume_error, 4, 0.15) << subdivisions;
    }
    area_error = new_area_error;
    volume_error = new_volume_error;
  }
  EXPECT_LT(volume_error / volume, 0.002);
}

TEST(Quad, LooksToTheSideOfTheCrossProduct) {
  const TriangleMesh mesh = make_quad({2, 0, 0}, {1, 3, 0});
  EXPECT_DOUBLE_EQ(area_of(mesh), 6);
  for (const auto& triangle : mesh.triangles) EXPECT_GT(face_vector(mesh, triangle)[2], 0);
}

TEST(Box, HasItsVolumeAreaAndPlace) {
  const TriangleMesh mesh = make_box({2, 3, 5});
  EXPECT_DOUBLE_EQ(volume_of(mesh), 30);
  EXPECT_DOUBLE_EQ(area_of(mesh), 62);
  EXPECT_TRUE(is_closed(mesh));
  for (Vec3 p : mesh.positions) {
    EXPECT_EQ(std::abs(p.x), 1);
    EXPECT_EQ(std::abs(p.y), 1.5f);
    EXPECT_TRUE(p.z == 0 || p.z == 5);
  }
}

// n flat strips of chord 2 r sin(pi / n) stand for the round of 2 pi r.
TEST(Lathe, OfACylinderHasTheAreaOfItsPrismAndNearlyOfTheRound) {
  const double r = 0.5, h = 2;
  for (int n : {12, 96}) {
    const TriangleMesh mesh = make_lathe({{0.5f, 0}, {0.5f, 1.5f}, {0.5f, 2}}, n);
    EXPECT_NEAR(area_of(mesh) / (n * 2 * r * std::sin(kPi / n) * h), 1, 1e-6);
    EXPECT_NEAR(area_of(mesh) / (2 * kPi * r * h), 1, kPi * kPi / (6.0 * n * n) * 1.01);
    expect_faces_along_normals(mesh, 180.0 / n + 0.01);
    for (Vec3 normal : mesh.normals) EXPECT_NEAR(normal.z, 0, 1e-6);
  }
}

// A cone of slant l has pi r l; with its base a whole, of volume pi r^2 h / 3.
TEST(Lathe, ThatReachesTheAxisClosesWithoutEmptyTriangles) {
  const TriangleMesh mesh = make_lathe({{0, 0}, {1, 0}, {0, 2}}, 400);
  EXPECT_NEAR(area_of(mesh), kPi * (1 + std::sqrt(5.0)), 1e-3);
  EXPECT_NEAR(volume_of(mesh), 2 * kPi / 3, 1e-3);
  EXPECT_EQ(mesh.triangles.size(), 800u);
  for (const auto& triangle : mesh.triangles) {
    const Double3 n = face_vector(mesh, triangle);
    EXPECT_GT(dot_of(n, n), 0);
  }
}

TEST(Lathe, IsSmoothOverSmallBendsAndSharpOverLargeOnes) {
  const TriangleMesh small = make_lathe({{1, 0}, {1, 1}, {0.9f, 2}}, 4);
  EXPECT_EQ(small.normals[4], small.normals[8]) << "the last ring of the first band, the first of the second";
  const TriangleMesh large = make_lathe({{1, 0}, {1, 1}, {0, 1}}, 4);
  EXPECT_NEAR(dot(large.normals[4], large.normals[8]), 0, 1e-6);
}

TEST(Sweep, OfAStraightTubeHasTheAreaOfItsPrism) {
  const double r = 0.1, n = 24, length_m = std::sqrt(14.0);
  const TriangleMesh mesh = make_sweep({{0, 0, 0}, {0.5f, 1, 1.5f}, {1, 2, 3}}, 0.1f, 24, 5);
  EXPECT_NEAR(area_of(mesh) / (n * 2 * r * std::sin(kPi / n) * length_m), 1, 1e-4);
  EXPECT_NEAR(area_of(mesh) / (2 * kPi * r * length_m), 1, 0.01);
  expect_faces_along_normals(mesh, 180 / n + 0.1);
}

TEST(Sweep, GoesThroughItsPointsAndLooksOutwards) {
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0.5f}, {1, 1, 1}, {0, 1, 1.5f}};
  const TriangleMesh mesh = make_sweep(points, 0.05f, 16, 16);
  for (Vec3 point : points) {
    float nearest = 1e9f;
    for (Vec3 p : mesh.positions) nearest = std::min(nearest, std::abs(length(p - point) - 0.05f));
    EXPECT_LT(nearest, 1e-5f);
  }
  expect_faces_along_normals(mesh, 30);
}

class Blob : public testing::TestWithParam<BlobParams> {};
INSTANTIATE_TEST_SUITE_P(OfTheStudy, Blob,
                         testing::Values(BlobParams{0.44f, 0.07f, 4, 11, 6},
                                         BlobParams{0.44f, 0.12f, 5, 11, 6},
                                         BlobParams{0.44f, 0.15f, 7, 11, 6}));

TEST_P(Blob, IsClosedAndStarShaped) {
  const TriangleMesh mesh = make_blob(GetParam());
  EXPECT_TRUE(is_closed(mesh));
  for (const auto& triangle : mesh.triangles) {
    const Double3 n = face_vector(mesh, triangle);
    for (std::uint32_t vertex : triangle) ASSERT_GT(dot_of(n, to_double(mesh.positions[vertex])), 0);
  }
}

// Neighbours of a vertex are not spread evenly, so the mean of its faces is off by the curvature times the
// edge: at most 1 degree at six subdivisions, and about half of what it is at five.
TEST_P(Blob, HasNormalsThatItsFacesAgreeWith) {
  BlobParams params = GetParam();
  const double fine = largest_normal_error(make_blob(params));
  params.subdivisions = 5;
  const double coarse = largest_normal_error(make_blob(params));
  EXPECT_LT(fine, 1);
  EXPECT_NEAR(coarse / fine, 2, 0.4);
  for (Vec3 normal : make_blob(params).normals) EXPECT_NEAR(length(normal), 1, 1e-6);
}

// log(r / radius) / amplitude has unit variance; over a sphere of few bumps its spread is loose.
TEST_P(Blob, VariesByItsAmplitudeAboutItsRadius) {
  const BlobParams params = GetParam();
  double sum = 0, squares = 0;
  const TriangleMesh mesh = make_blob(params);
  for (Vec3 p : mesh.positions) {
    const double value = std::log(length(p) / params.radius) / params.amplitude;
    sum += value;
    squares += value * value;
  }
  const auto count = static_cast<double>(mesh.positions.size());
  EXPECT_NEAR(sum / count, 0, 0.5);
  EXPECT_NEAR(squares / count, 1, 0.5);
}

TEST_P(Blob, IsAnotherForAnotherSeedAndTheSameForTheSame) {
  BlobParams params = GetParam();
  params.subdivisions = 3;
  const TriangleMesh mesh = make_blob(params), again = make_blob(params);
  params.seed += 1;
  const TriangleMesh other = make_blob(params);
  EXPECT_EQ(mesh.positions, again.positions);
  EXPECT_NE(mesh.positions, other.positions);
}

TEST(BlobParameters, OfNoAmplitudeGiveASphere) {
  const TriangleMesh blob = make_blob({0.5f, 0, 5, 1, 3}), sphere = make_sphere(0.5f, 3);
  for (std::size_t i = 0; i < blob.positions.size(); ++i) {
    EXPECT_NEAR(length(blob.positions[i] - sphere.positions[i]), 0, 1e-7);
    EXPECT_NEAR(dot(blob.normals[i], sphere.normals[i]), 1, 1e-6);
  }
}

using Outline = std::vector<std::array<float, 2>>;

// An L of arms 3 and 2, one wide: area 4, outline 10.
const Outline kL{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};

Outline reversed(Outline outline) {
  std::reverse(outline.begin(), outline.end());
  return outline;
}

// The divergence theorem gives the same volume about every origin only if the surface closes.
TEST(Extrude, OfAnOutlineThatIsNotConvexHasItsAreaAndVolumeAndCloses) {
  for (const Outline& outline : {kL, reversed(kL)}) {
    TriangleMesh mesh = make_extrude(outline, 5);
    EXPECT_NEAR(area_of(mesh), 2 * 4 + 10 * 5, 1e-5);
    EXPECT_NEAR(volume_of(mesh), 4 * 5, 1e-5);
    for (Vec3& p : mesh.positions) p += {7, -3, 11};
    EXPECT_NEAR(volume_of(mesh), 4 * 5, 1e-3);
    expect_faces_along_normals(mesh, 0.01);
  }
}

// Points on a straight edge and a spiral, in which few corners can be cut off at any time.
TEST(Extrude, OfLongAndWoundOutlinesFillsThem) {
  Outline straight{{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {2, 1}, {1, 1}, {0, 1}, {0, 0.5f}};
  EXPECT_NEAR(volume_of(make_extrude(straight, 2)), 6, 1e-5);
  Outline spiral;
  for (int i = 0; i <= 200; ++i) {
    const double angle = 0.08 * i, r = 1 + 0.1 * angle;
    spiral.push_back({static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle))});
  }
  for (int i = 200; i >= 0; --i) {
    const double angle = 0.08 * i, r = 1.3 + 0.1 * angle;
    spiral.push_back({static_cast<float>(r * std::cos(angle)), static_cast<float>(r * std::sin(angle))});
  }
  ASSERT_TRUE(is_simple_outline(spiral));
  double area = 0;
  for (std::size_t i = 0; i < spiral.size(); ++i) {
    const auto &a = spiral[i], &b = spiral[(i + 1) % spiral.size()];
    area += (double{a[0]} * b[1] - double{b[0]} * a[1]) / 2;
  }
  EXPECT_NEAR(volume_of(make_extrude(spiral, 1)), std::abs(area), 1e-4);
}

TEST(Extrude, RoundsASideOfSmallBendsOnly) {
  Outline circle;
  for (int i = 0; i < 24; ++i)
    circle.push_back({std::cos(static_cast<float>(i) * 0.2618f), std::sin(static_cast<float>(i) * 0.2618f)});
  const TriangleMesh round = make_extrude(circle, 1);
  for (std::size_t i = 0; i < 4 * circle.size(); ++i)
    EXPECT_NEAR(dot(round.normals[i], normalize({round.positions[i].x, round.positions[i].y, 0})), 1, 1e-4);
  const TriangleMesh square = make_extrude({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1);
  EXPECT_NEAR(dot(square.normals[1], square.normals[4]), 0, 1e-6);
}

TEST(Outline, ThatMeetsItselfIsNotSimple) {
  EXPECT_TRUE(is_simple_outline(kL));
  EXPECT_FALSE(is_simple_outline({{0, 0}, {1, 1}, {1, 0}, {0, 1}})) << "crosses";
  EXPECT_FALSE(is_simple_outline({{0, 0}, {2, 0}, {2, 1}, {1, 0}, {0, 1}})) << "touches an edge";
  EXPECT_FALSE(is_simple_outline({{0, 0}, {1, 0}, {1, 0}, {0, 1}})) << "a point twice";
  EXPECT_FALSE(is_simple_outline({{0, 0}, {1, 0}, {2, 0}})) << "no area";
  EXPECT_FALSE(is_simple_outline({{0, 0}, {1, 0}}));
}

// 20,000 copies over a sphere, in 8 x 8 cells of equal area, level .001, seed 3.
TEST(Scatter, IsEvenByAreaOverItsMesh) {
  const TriangleMesh point = make_quad({1e-5f, 0, 0}, {0, 1e-5f, 0});
  const TriangleMesh mesh = make_scatter(point, make_sphere(1, 5), {20000, 3, 1, 1, 0});
  ASSERT_EQ(mesh.triangles.size(), 40000u);
  std::vector<double> counts(64), expected(64, 20000.0 / 64);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 4) {
    const Vec3 p = mesh.positions[i];
    const int row = std::clamp(static_cast<int>((p.z + 1) * 4), 0, 7);
    const int column = std::clamp(static_cast<int>((std::atan2(p.y, p.x) / kPi + 1) * 4), 0, 7);
    ++counts[static_cast<std::size_t>(row * 8 + column)];
  }
  EXPECT_GT(test::test_chi_squared(counts, expected).p, 0.001);
}

TEST(Scatter, StandsItsCopiesOnTheSurfaceWithinTheirLeanAndScale) {
  const TriangleMesh post = make_box({0.001f, 0.001f, 0.1f});
  const TriangleMesh mesh = make_scatter(post, make_sphere(1, 5), {300, 1, 0.5f, 2, 30});
  double shortest = 1, longest = 0, most = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); i += 8) {
    const Vec3 foot = (mesh.positions[i] + mesh.positions[i + 2]) / 2,
               head = (mesh.positions[i + 4] + mesh.positions[i + 6]) / 2;
    EXPECT_NEAR(length(foot), 1, 1e-2);
    shortest = std::min<double>(shortest, length(head - foot));
    longest = std::max<double>(longest, length(head - foot));
    most = std::max(most, angle_between(to_double(head - foot), to_double(foot)));
  }
  EXPECT_GE(shortest, 0.05 - 1e-4);
  EXPECT_LT(shortest, 0.06);
  EXPECT_LE(longest, 0.2 + 1e-4);
  EXPECT_GT(longest, 0.19);
  EXPECT_LT(most, 30 + 2.5) << "faces of this sphere lean by up to 2.5 degrees themselves";
  EXPECT_GT(most, 25);
}

TEST(Scatter, KeepsItsFirstCopiesWhenMoreAreAsked) {
  const TriangleMesh part = make_box({1, 1, 1}), over = make_quad({9, 0, 0}, {0, 9, 0});
  const TriangleMesh few = make_scatter(part, over, {5, 2, 1, 3, 90}),
                     many = make_scatter(part, over, {9, 2, 1, 3, 90});
  EXPECT_TRUE(std::equal(few.positions.begin(), few.positions.end(), many.positions.begin()));
  EXPECT_NE(make_scatter(part, over, {5, 3, 1, 3, 90}).positions, few.positions);
}

TEST(Generators, RefuseParametersThatTheSchemaNeverLetsThrough) {
  EXPECT_THROW(make_sphere(1, 9), CheckFailure);
  EXPECT_THROW(make_lathe({{1, 0}}, 8), CheckFailure);
  EXPECT_THROW(make_extrude({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 1), CheckFailure);
  EXPECT_THROW(make_sweep({{0, 0, 0}, {1, 0, 0}}, 0.1f, 2, 1), CheckFailure);
}

}  // namespace
}  // namespace equilux
