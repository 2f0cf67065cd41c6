// What leaves the lights, against its densities: chi-squared with independent draws, 400,000 samples each.
#include "renderer/lights.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/renderer/test_scene.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

constexpr int kSamples = 400000;
constexpr double kPi2 = 2 * std::numbers::pi;
// Level 1 % over the 17 chi-squared tests of this file.
constexpr double kLevel = .01 / 17;

World world_of(const std::string& lights) {
  test::SceneText text;
  text.lights = lights;
  return make_world(test::make_scene(text), "G0", Illumination::kIndirect);
}

std::string spot_text(double inner, double outer, double x = 1, double intensity = 1) {
  return fmt::format(
      R"({{"spot":{{"position":[{},2,3],"target":[2,4,1],"inner_degrees":{},"outer_degrees":{},"intensity":[{},1,1]}}}})",
      x, inner, outer, intensity);
}

std::vector<LightParticle> sample_particles(const World& world, std::uint64_t seed) {
  PathSampler sampler(RandomStream(seed, "lights", 0), false);
  std::vector<LightParticle> particles;
  for (int i = 0; i < kSamples; ++i) {
    sampler.next_path();
    particles.push_back(sample_emission(world, sampler).value());
  }
  return particles;
}

std::size_t bin_of(double share, std::size_t bins) {
  return std::min(bins - 1, static_cast<std::size_t>(std::max(0.0, share) * static_cast<double>(bins)));
}

double azimuth_share(Vec3 local) { return std::atan2(local.y, local.x) / kPi2 + .5; }

// p of samples that are said to be even over all bins; `factor` times too many are expected in the first
// half, as many too few in the second.
double fit_even(const std::vector<double>& observed, double factor = 1) {
  double sum = 0;
  for (double count : observed) sum += count;
  std::vector<double> expected(observed.size(), sum / static_cast<double>(observed.size()));
  for (std::size_t i = 0; i < expected.size(); ++i)
    expected[i] *= i < expected.size() / 2 ? factor : 2 - factor;
  return test::test_chi_squared(observed, expected).p;
}

// Directions of a spot in bins that are even over its cone: cosine x azimuth.
std::vector<double> count_cone(const std::vector<LightParticle>& particles, const SpotLight& spot) {
  const Frame frame(spot.direction);
  std::vector<double> observed(12 * 16);
  for (const LightParticle& particle : particles) {
    const Vec3 local = frame.to_local(particle.direction);
    const double share = (1 - double(local.z)) / (1 - double(spot.cos_outer));
    ++observed[bin_of(share, 12) * 16 + bin_of(azimuth_share(local), 16)];
  }
  return observed;
}

// One minus a cosine in float has few digits left at half a degree: the bins' edges are then wrong by
// rounding.
TEST(Lights, ASpotsParticlesAreEvenInItsCone) {
  std::uint64_t seed = 0;
  for (double outer : {3.0, 10.0, 40.0, 80.0, 89.9}) {
    const World world = world_of("[" + spot_text(outer / 2, outer) + "]");
    EXPECT_GT(fit_even(count_cone(sample_particles(world, ++seed), world.spots()[0])), kLevel) << outer;
  }
}

TEST(Lights, ASpotsParticlesWeighItsIntensityOverTheirDensity) {
  const World world = world_of("[" + spot_text(20, 50) + "]");
  const SpotLight& spot = world.spots()[0];
  const float pdf = 1 / (2 * kPi * (1 - spot.cos_outer));
  for (const LightParticle& particle : sample_particles(world, 1)) {
    ASSERT_EQ(particle.origin, spot.position);
    ASSERT_NEAR(particle.weight.x * pdf, eval_spot(spot, particle.direction).x, 1e-5);
  }
}

// Points and directions of a rectangle together, so that one cannot hang on the other: side x side x squared
// sine x azimuth, even under a cosine.
std::vector<double> count_rectangle(const std::vector<LightParticle>& particles,
                                    const RectangleLight& light) {
  const Frame frame(rectangle_normal(light));
  std::vector<double> observed(4 * 4 * 4 * 4);
  for (const LightParticle& particle : particles) {
    const Vec3 from = particle.origin - light.corner, local = frame.to_local(particle.direction);
    const double a = dot(from, light.u) / dot(light.u, light.u),
                 b = dot(from, light.v) / dot(light.v, light.v);
    const double sine2 = 1 - double(local.z) * local.z;
    ++observed[((bin_of(a, 4) * 4 + bin_of(b, 4)) * 4 + bin_of(sine2, 4)) * 4 +
               bin_of(azimuth_share(local), 4)];
  }
  return observed;
}

constexpr const char* kRectangle =
    R"({"rectangle":{"corner":[1,2,3],"u":[0,0.5,0],"v":[2,0,0],"radiance":[6,5,4]}})";

TEST(Lights, ARectanglesParticlesAreEvenOverItAndFollowTheCosine) {
  const World world = world_of(fmt::format("[{}]", kRectangle));
  EXPECT_GT(fit_even(count_rectangle(sample_particles(world, 11), world.rectangles()[0])), kLevel);
}

// Directions and points of entry of the environment's particles: cosine x azimuth x squared distance from the
// axis x angle around it.
std::vector<double> count_environment(const std::vector<LightParticle>& particles, const World& world) {
  std::vector<double> observed(4 * 4 * 4 * 4);
  for (const LightParticle& particle : particles) {
    const Vec3 d = particle.direction;
    const Vec3 across = Frame(d).to_local(particle.origin - world.center());
    const double r2 = (double(across.x) * across.x + double(across.y) * across.y) /
                      (double(world.radius()) * world.radius());
    ++observed[((bin_of((1 - double(d.z)) / 2, 4) * 4 + bin_of(azimuth_share(d), 4)) * 4 + bin_of(r2, 4)) *
                   4 +
               bin_of(azimuth_share(across), 4)];
  }
  return observed;
}

TEST(Lights, TheEnvironmentsParticlesAreEvenOverAllDirectionsAndTheDiskAcross) {
  const World world = world_of(R"([{"environment":{"radiance":[1,2,3]}}])");
  const auto particles = sample_particles(world, 12);
  EXPECT_GT(fit_even(count_environment(particles, world)), kLevel);
  // All the flux that enters the sphere: radiance x 4 pi x the disk.
  for (const LightParticle& particle : particles)
    ASSERT_NEAR(particle.weight.x, 4 * kPi * kPi * world.radius() * world.radius(), 1e-3);
}

// Mutants: densities wrong by two per cent.
TEST(Lights, AMutantDensityWrongByTwoPercentIsCaught) {
  const World spots = world_of("[" + spot_text(20, 40) + "]"),
              rectangles = world_of(fmt::format("[{}]", kRectangle)),
              open = world_of(R"([{"environment":{"radiance":[1,2,3]}}])");
  const auto cone = count_cone(sample_particles(spots, 1), spots.spots()[0]),
             rectangle = count_rectangle(sample_particles(rectangles, 11), rectangles.rectangles()[0]),
             sphere = count_environment(sample_particles(open, 12), open);
  for (double factor : {.98, 1.02}) {
    EXPECT_LT(fit_even(cone, factor), kLevel);
    EXPECT_LT(fit_even(rectangle, factor), kLevel);
    EXPECT_LT(fit_even(sphere, factor), kLevel);
  }
}

// Which light a particle leaves: in proportion to spots' cone and luminance, a rectangle's power, and the
// environment's flux through the world's sphere. What it weighs makes up for that.
TEST(Lights, ParticlesChooseLightsInProportionToBoundsOfTheirPower) {
  const World world = world_of(fmt::format(R"([{},{},{},{{"environment":{{"radiance":[1,1,1]}}}}])",
                                           spot_text(20, 40, 1, 100), spot_text(5, 10, 4, 5000), kRectangle));
  std::vector<double> powers;
  for (const SpotLight& spot : world.spots())
    powers.push_back(luminance(spot.intensity_w_per_sr) * kPi2 * (1 - double(spot.cos_outer)));
  const RectangleLight& light = world.rectangles()[0];
  powers.push_back(luminance(light.radiance_w_per_m2_sr) * std::numbers::pi * rectangle_area(light));
  powers.push_back(4 * std::numbers::pi * std::numbers::pi * world.radius() * world.radius());
  double total = 0;
  for (double power : powers) total += power;
  std::vector<double> observed(powers.size()), expected;
  for (double power : powers) expected.push_back(kSamples * power / total);
  const auto chosen = [&](const LightParticle& particle) -> std::size_t {
    for (std::size_t i = 0; i < 2; ++i)
      if (particle.origin == world.spots()[i].position) return i;
    return length(particle.origin - world.center()) < world.radius() * .99f ? 2 : 3;
  };
  for (const LightParticle& particle : sample_particles(world, 13)) ++observed[chosen(particle)];
  EXPECT_GT(test::test_chi_squared(observed, expected).p, kLevel)
      << fmt::format("{} {}", fmt::join(observed, ","), fmt::join(expected, ","));
}

// Even choice of points on a rectangle, seen from x: bins over the sphere of directions (cosine x azimuth
// about the way to its middle) against pdf_rectangle by quadrature over 2,048 x 2,048 directions; what lies
// behind the light has no density and is a bin of its own.
double fit_solid_angle(const RectangleLight& light, Vec3 x, std::uint64_t seed, double factor = 1) {
  constexpr int kRings = 16, kSectors = 16, kFine = 128;
  const Vec3 middle = light.corner + (light.u + light.v) * .5f;
  const Frame frame(normalize(middle - x));
  const Vec3 normal = rectangle_normal(light);
  // Rings of equal solid angle within the cone that holds the rectangle.
  double widest = 1;
  for (Vec3 corner :
       {light.corner, light.corner + light.u, light.corner + light.v, light.corner + light.u + light.v})
    widest = std::min(widest, double(frame.to_local(normalize(corner - x)).z));
  const auto bin = [&](Vec3 local) {
    return bin_of((1 - double(local.z)) / (1 - widest), kRings) * kSectors +
           bin_of(azimuth_share(local), kSectors);
  };
  std::vector<double> observed(kRings * kSectors + 1), expected(observed.size());
  RandomStream random(seed, "rectangle", 0);
  for (int i = 0; i < kSamples; ++i) {
    const float a = random.next_float(), b = random.next_float();
    const Vec3 p = light.corner + light.u * a + light.v * b;
    ++(pdf_rectangle(light, x, p) > 0 ? observed[bin(frame.to_local(normalize(p - x)))] : observed.back());
  }
  double kept = 0;
  const double cell = kPi2 * (1 - widest) / (double(kRings) * kFine * kSectors * kFine);
  for (int i = 0; i < kRings * kFine; ++i) {
    for (int j = 0; j < kSectors * kFine; ++j) {
      const double z = 1 - (i + .5) / (kRings * kFine) * (1 - widest),
                   phi = ((j + .5) / (kSectors * kFine) - .5) * kPi2, s = std::sqrt(1 - z * z);
      const Vec3 local{float(s * std::cos(phi)), float(s * std::sin(phi)), float(z)};
      const Vec3 d = frame.to_world(local);
      const float t = dot(normal, light.corner - x) / dot(normal, d);
      const Vec3 p = x + d * t, from = p - light.corner;
      const float a = dot(from, light.u) / dot(light.u, light.u),
                  b = dot(from, light.v) / dot(light.v, light.v);
      if (!(t > 0 && a >= 0 && a < 1 && b >= 0 && b < 1)) continue;
      const double share = pdf_rectangle(light, x, p) * cell;
      expected[bin(local)] += share * kSamples * factor;
      kept += share * factor;
    }
  }
  expected.back() = std::max(0.0, 1 - kept) * kSamples;
  return test::test_chi_squared(observed, expected).p;
}

TEST(Lights, PointsOfARectangleFollowTheirDensityOverSolidAngle) {
  const RectangleLight light{{-1, -.5f, 2}, {0, 1, 0}, {2, 0, 0}, {1, 1, 1}};  // shines down
  std::uint64_t seed = 20;
  for (Vec3 x :
       {Vec3{0, 0, 0}, Vec3{3, 1, 0}, Vec3{.2f, -.3f, 1.7f}, Vec3{0, 0, -50}, Vec3{20, 0, 0}, Vec3{0, 0, 3}})
    EXPECT_GT(fit_solid_angle(light, x, ++seed), kLevel) << x.x << " " << x.z;
}

TEST(Lights, AMutantDensityOverSolidAngleWrongByTwoPercentIsCaught) {
  const RectangleLight light{{-1, -.5f, 2}, {0, 1, 0}, {2, 0, 0}, {1, 1, 1}};
  for (double factor : {.98, 1.02}) EXPECT_LT(fit_solid_angle(light, {3, 1, 0}, 22, factor), kLevel);
}

}  // namespace
}  // namespace equilux
