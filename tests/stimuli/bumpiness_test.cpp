// Shapes whose bumpiness has a closed form or an integral of one variable.
#include "stimuli/bumpiness.h"

#include <gtest/gtest.h>

#include "stimuli/generators.h"
#include "stimuli/scene.h"
#include "tests/stimuli/mesh_measures.h"

namespace equilux {
namespace {

constexpr double kPi = std::numbers::pi;

// r = exp(a Y_l0) about the origin, on a sphere's triangles; normals exact.
struct Zonal {
  unsigned degree;
  double amplitude;

  double log_radius(double polar) const { return amplitude * std::sph_legendre(degree, 0, polar); }
  double slope(double polar) const {
    constexpr double kStep = 1e-5;
    return (log_radius(polar + kStep) - log_radius(polar - kStep)) / (2 * kStep);
  }
};

TriangleMesh make_zonal(const Zonal& zonal) {
  TriangleMesh mesh = make_sphere(1, 6);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const Vec3 d = mesh.normals[i];
    const double polar = std::acos(std::clamp(double(d.z), -1., 1.));
    const Vec3 south = normalize(d * d.z - Vec3{0, 0, 1});
    mesh.positions[i] = d * static_cast<float>(std::exp(zonal.log_radius(polar)));
    mesh.normals[i] = normalize(d - south * static_cast<float>(zonal.slope(polar)));
  }
  return mesh;
}

// The angle's tangent is the slope of ln r; the area grows with r^2 and the angle's secant.
double zonal_rms_angle(const Zonal& zonal) {
  constexpr int kSteps = 20000;
  double sum = 0, area = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double polar = kPi * (i + .5) / kSteps, angle = std::atan(std::abs(zonal.slope(polar)));
    const double weight = std::exp(2 * zonal.log_radius(polar)) / std::cos(angle) * std::sin(polar);
    sum += weight * angle * angle;
    area += weight;
  }
  return std::sqrt(sum / area) * 180 / kPi;
}

TEST(Bumpiness, OfASphereIsZero) {
  const Bumpiness sphere = measure_bumpiness(make_sphere(.45f, 6));
  EXPECT_LT(length(sphere.center_m), 1e-6);
  EXPECT_NEAR(sphere.mean_radius_m, .45, 1e-4) << "facets lie a little inside";
  EXPECT_NEAR(sphere.max_radius_m, .45, 1e-6);
  EXPECT_LT(sphere.rms_angle_degrees, 1e-3);
  for (double band : sphere.rms_log_radius) EXPECT_LT(band, 1e-5);
  EXPECT_EQ(sphere.open_share, 0);
}

// At degree 16 an edge spans a twentieth of a wave, which takes half a per cent off its height.
TEST(Bumpiness, OfOneHarmonicIsInItsBandAlone) {
  const std::pair<unsigned, std::size_t> bands[] = {{2, 1}, {3, 1}, {4, 2}, {7, 2}, {8, 3}, {15, 3}, {16, 4}};
  for (const auto& [degree, band] : bands) {
    SCOPED_TRACE(degree);
    const Zonal zonal{degree, .1};
    const Bumpiness bumpiness = measure_bumpiness(make_zonal(zonal));
    const double rms = zonal.amplitude / std::sqrt(4 * kPi);
    for (std::size_t i = 0; i < kBumpBands; ++i)
      EXPECT_NEAR(bumpiness.rms_log_radius[i], i == band ? rms : 0, (i == band ? .01 : .03) * rms) << i;
    EXPECT_NEAR(bumpiness.rms_angle_degrees / zonal_rms_angle(zonal), 1, .01);
    EXPECT_LT(length(bumpiness.center_m), .01);
  }
}

// Degree 1 is taken up by the centre, nearly: what is left of a sphere beside the origin is its offset's
// square.
TEST(Bumpiness, OfDegreeOneIsTakenUpByTheCentre) {
  const Bumpiness bumpiness = measure_bumpiness(make_zonal({1, .1}));
  EXPECT_LT(bumpiness.rms_log_radius[0], .002);
  EXPECT_NEAR(bumpiness.center_m.z, .1 * std::sqrt(3 / (4 * kPi)), .001);
}

TriangleMesh make_ellipsoid(Vec3 axes) {
  TriangleMesh mesh = make_sphere(1, 6);
  for (Vec3& p : mesh.positions) p = p * axes;
  for (Vec3& n : mesh.normals) n = normalize({n.x / axes.x, n.y / axes.y, n.z / axes.z});
  return mesh;
}

// Over the unit sphere d: p = (a x, b y, c z), normal and area along and as long as (x / a, y / b, z / c).
double ellipsoid_rms_angle(Vec3 axes) {
  constexpr int kSteps = 600;
  double sum = 0, area = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < 2 * kSteps; ++j) {
      const double z = (2 * i + 1.) / kSteps - 1, phi = kPi * (j + .5) / kSteps, s = std::sqrt(1 - z * z);
      const Double3 p{axes.x * s * std::cos(phi), axes.y * s * std::sin(phi), axes.z * z},
          n{s * std::cos(phi) / axes.x, s * std::sin(phi) / axes.y, z / axes.z};
      const double weight = std::sqrt(dot_of(n, n));
      sum += weight * std::pow(angle_between(n, p), 2);
      area += weight;
    }
  }
  return std::sqrt(sum / area);
}

TEST(Bumpiness, OfAnEllipsoidIsItsIntegral) {
  const Vec3 axes{1, .7f, .5f};
  EXPECT_NEAR(measure_bumpiness(make_ellipsoid(axes)).rms_angle_degrees / ellipsoid_rms_angle(axes), 1, .002);
}

void expect_same_shape(const Bumpiness& a, const Bumpiness& b, double scale) {
  EXPECT_NEAR(b.rms_angle_degrees / a.rms_angle_degrees, 1, 1e-4);
  EXPECT_NEAR(b.max_radius_m / a.max_radius_m, scale, 1e-4 * scale);
  EXPECT_NEAR(b.mean_radius_m / a.mean_radius_m, scale, 1e-4 * scale);
  for (std::size_t i = 0; i < kBumpBands; ++i)
    EXPECT_NEAR(a.rms_log_radius[i], b.rms_log_radius[i], 1e-4 + 1e-3 * a.rms_log_radius[i]) << i;
}

TEST(Bumpiness, DoesNotDependOnScalePlaceAndTurn) {
  const TriangleMesh blob = make_blob({.44f, .15f, 5, 3, 6});
  const Bumpiness here = measure_bumpiness(blob);
  for (float scale : {1.0f, 1e-3f, 700.0f}) {
    const TriangleMesh there = place_mesh(blob, {{3 * scale, -2 * scale, scale}, 33, 71, scale});
    expect_same_shape(here, measure_bumpiness(there), scale);
  }
}

TEST(Bumpiness, OfBlobsIsAboutTheGeneratorsCentreAndGrows) {
  double angle = 0;
  for (float amplitude : {.05f, .1f, .2f}) {
    const Bumpiness blob = measure_bumpiness(make_blob({.44f, amplitude, 6, 5, 5}));
    EXPECT_LT(length(blob.center_m), .15 * .44 * amplitude / .1);
    EXPECT_GT(blob.rms_angle_degrees, 1.5 * angle);
    angle = blob.rms_angle_degrees;
  }
}

TEST(Bumpiness, OfAShapeTurnedInsideOutIsTheSame) {
  TriangleMesh blob = make_blob({.44f, .15f, 5, 3, 4});
  const Bumpiness outwards = measure_bumpiness(blob);
  for (auto& triangle : blob.triangles) std::swap(triangle[0], triangle[1]);
  for (Vec3& normal : blob.normals) normal = -normal;
  expect_same_shape(outwards, measure_bumpiness(blob), 1);
}

TEST(Bumpiness, WithAHoleLeavesItOut) {
  TriangleMesh sphere = make_sphere(1, 5);
  std::erase_if(sphere.triangles, [&](const auto& t) { return sphere.positions[t[0]].z > .98f; });
  const Bumpiness bumpiness = measure_bumpiness(sphere);
  EXPECT_NEAR(bumpiness.open_share, .01, .003);
  EXPECT_LT(bumpiness.rms_log_radius[0], .02) << "the centre is a little lower";
}

TEST(Bumpiness, OfASheetIsFinite) {
  const Bumpiness sheet = measure_bumpiness(make_quad({2, 0, 0}, {0, 1, 0}));
  EXPECT_EQ(sheet.center_m, (Vec3{1, .5f, 0}));
  EXPECT_NEAR(sheet.rms_angle_degrees, 90, 1e-6);
  EXPECT_NEAR(sheet.open_share, 1, 1e-9);
  for (double band : sheet.rms_log_radius) EXPECT_EQ(band, 0);
}

// A cube of half side 1: its outermost radius along (x, y, z) is 1 / max |x|.
TEST(Bumpiness, OfLargeTrianglesMeetsEveryDirection) {
  const Bumpiness cube = measure_bumpiness(make_box({2, 2, 2}));
  EXPECT_EQ(cube.open_share, 0);
  EXPECT_NEAR(cube.max_radius_m, std::sqrt(3.0), 1e-6);
  EXPECT_LT(cube.rms_log_radius[0], 1e-3);
  EXPECT_LT(cube.rms_log_radius[1], 1e-3) << "cubes have no degrees 1 to 3";
  EXPECT_GT(cube.rms_log_radius[2], .05);
}

}  // namespace
}  // namespace equilux
