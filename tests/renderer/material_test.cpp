// BRDFs against quadrature, reciprocity and chi-squared.
#include "renderer/material.h"

#include <functional>
#include <gtest/gtest.h>

#include "base/random.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

Vec3 direction(double degrees, double phi = 0) {
  const double t = degrees * std::numbers::pi / 180;
  return {static_cast<float>(std::sin(t) * std::cos(phi)), static_cast<float>(std::sin(t) * std::sin(phi)),
          static_cast<float>(std::cos(t))};
}

Material ward(float alpha) {
  return make_material({"", {0.03f, 0.03f, 0.03f}, {0.22f, 0.22f, 0.22f}, alpha});
}

// Albedo of the glossy lobe over rho_s. In half-vector space, dl = 4 (h.v) dh, the lobe is smooth: midpoint
// rule over tan t and phi.
double lobe_albedo(double alpha, double view_degrees) {
  const double tv = view_degrees * std::numbers::pi / 180, sv = std::sin(tv), cv = std::cos(tv);
  const int rings = 4000, sectors = 2000;
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    const double u = (i + 0.5) / rings;  // the lobe's own distribution, E tan t dt
    const double tan_t = alpha * std::sqrt(-std::log(u)), cos_t = 1 / std::sqrt(1 + tan_t * tan_t),
                 sin_t = tan_t * cos_t;
    for (int j = 0; j < sectors; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / sectors;
      const double hv = sin_t * std::cos(phi) * sv + cos_t * cv;
      const double lz = 2 * hv * cos_t - cv;
      // weight f_s cl / pdf = (h.n)^2 (cv + cl) / (2 cv), zero where the direction is rejected
      if (hv > 0 && lz > 0) sum += cos_t * cos_t * (cv + lz) / (2 * cv);
    }
  }
  return sum / (double(rings) * sectors);
}

// The same albedo through eval_glossy, by the midpoint rule over the hemisphere of light directions.
double lobe_albedo_of_eval(float alpha, double view_degrees) {
  const Vec3 v = direction(view_degrees);
  const int n = 1200;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double theta = (i + 0.5) / n * std::numbers::pi / 2;
    for (int j = 0; j < n; ++j) {
      const double phi = 2 * std::numbers::pi * (j + 0.5) / n;
      const Vec3 l = direction(theta * 180 / std::numbers::pi, phi);
      sum += eval_glossy(alpha, v, l) * std::cos(theta) * std::sin(theta);
    }
  }
  return sum * (std::numbers::pi / 2 / n) * (2 * std::numbers::pi / n);
}

TEST(Material, LobeAlbedoMatchesTheTableOfLightTransport) {
  EXPECT_NEAR(lobe_albedo(.15, 60), .955, .001);
  EXPECT_NEAR(lobe_albedo(.15, 80), .923, .001);
  EXPECT_NEAR(lobe_albedo(.15, 85), 1.05, .01);
  EXPECT_NEAR(lobe_albedo(.15, 88), 1.66, .01);
  EXPECT_NEAR(lobe_albedo(.15, 89.5), 5.0, .05);
  EXPECT_NEAR(lobe_albedo(.15, 89.9), 23, .5);
  EXPECT_NEAR(lobe_albedo(.05, 60), .995, .001);
  EXPECT_NEAR(lobe_albedo(.05, 85), .962, .001);
  EXPECT_NEAR(lobe_albedo(.05, 89.9), 8.5, .05);
}

TEST(Material, EvalIntegratesToTheSameAlbedoAsItsSamplingWeights) {
  for (double degrees : {0.0, 30.0, 60.0, 80.0}) {
    EXPECT_NEAR(lobe_albedo_of_eval(.15f, degrees), lobe_albedo(.15, degrees), .001) << degrees;
  }
}

TEST(Material, IsReciprocal) {
  RandomStream random(7, "reciprocity", 0);  // 10,000 pairs of directions
  for (int i = 0; i < 10000; ++i) {
    const Vec3 a = sample_cosine(random.next_float(), random.next_float());
    const Vec3 b = sample_cosine(random.next_float(), random.next_float());
    if (a.z < 1e-3f || b.z < 1e-3f) continue;
    const float forth = eval_brdf(ward(.15f), a, b).x, back = eval_brdf(ward(.15f), b, a).x;
    ASSERT_NEAR(forth, back, 1e-5f * std::max(1.0f, forth)) << i;
  }
}

TEST(Material, IsZeroBelowTheHorizon) {
  EXPECT_EQ(eval_brdf(ward(.1f), direction(30), direction(100)), Vec3{});
  EXPECT_EQ(pdf_brdf(ward(.1f), direction(30), direction(100)), 0);
}

constexpr int kPolar = 12, kAzimuth = 16, kSamples = 500000;

// Bins over the half vector's angle (even in the lobe's own u) and azimuth; rejected directions have a bin of
// their own.
struct Binned {
  std::vector<double> observed = std::vector<double>(kPolar * kAzimuth + 1);
  std::vector<double> expected = std::vector<double>(kPolar * kAzimuth + 1);
};

// Samples of the glossy lobe against its density integrated over the bins of the half vector. shape of a bin:
// u x phi.
Binned bin_glossy(float alpha, double view_degrees, std::uint64_t seed, double pdf_factor) {
  const int samples = kSamples;
  const Vec3 v = direction(view_degrees);
  Binned bins;
  RandomStream random(seed, "chi-squared", 0);
  for (int i = 0; i < samples; ++i) {
    const float u1 = random.next_float(), u2 = random.next_float();
    const auto l = sample_glossy(alpha, v, u1, u2);
    if (!l) {
      ++bins.observed.back();
      continue;
    }
    const Vec3 h = normalize(v + *l);
    const double u = std::exp(-double(h.x * h.x + h.y * h.y) / (double(h.z) * h.z * alpha * alpha));
    const double phi = std::atan2(h.y, h.x) + std::numbers::pi;
    const int a = std::min(kPolar - 1, static_cast<int>(u * kPolar));
    const int b = std::min(kAzimuth - 1, static_cast<int>(phi / (2 * std::numbers::pi) * kAzimuth));
    ++bins.observed[static_cast<std::size_t>(a * kAzimuth + b)];
  }
  // Expected: pdf(l) dl with dl = 4 (h.v) dh and dh = sin t dt dphi, by the midpoint rule inside each bin.
  const int fine = 24;
  double kept = 0;
  for (int a = 0; a < kPolar; ++a) {
    for (int b = 0; b < kAzimuth; ++b) {
      double sum = 0;
      for (int i = 0; i < fine; ++i) {
        for (int j = 0; j < fine; ++j) {
          const double u = (a + (i + .5) / fine) / kPolar;
          const double phi = 2 * std::numbers::pi * (b + (j + .5) / fine) / kAzimuth - std::numbers::pi;
          const double tan_t = alpha * std::sqrt(-std::log(u)), cos_t = 1 / std::sqrt(1 + tan_t * tan_t);
          const Vec3 h{static_cast<float>(tan_t * cos_t * std::cos(phi)),
                       static_cast<float>(tan_t * cos_t * std::sin(phi)), static_cast<float>(cos_t)};
          const float hv = dot(h, v);
          const Vec3 l = 2 * hv * h - v;
          if (hv <= 0 || l.z <= 0) continue;
          // dh = cos^3 t alpha^2 / (2 u) du dphi, from u = exp(-tan^2 t / alpha^2)
          const double dh = cos_t * cos_t * cos_t * alpha * alpha / (2 * u);
          sum += pdf_factor * pdf_glossy(alpha, v, l) * 4 * hv * dh;
        }
      }
      const double share = sum / (fine * fine) / kPolar * (2 * std::numbers::pi / kAzimuth);
      bins.expected[static_cast<std::size_t>(a * kAzimuth + b)] = share * samples;
      kept += share;
    }
  }
  bins.expected.back() = std::max(0.0, 1 - kept) * samples;
  return bins;
}

// Chi-squared over the bins that the horizon does not cut (those it cuts are integrated too coarsely), and
// the share of rejected directions, which the density must leave over.
struct Fit {
  double p;
  double rejected_observed, rejected_expected;
};

Fit fit_glossy(float alpha, double view_degrees, std::uint64_t seed, double pdf_factor) {
  const Binned bins = bin_glossy(alpha, view_degrees, seed, pdf_factor);
  std::vector<double> observed, expected;
  const double full = double(kSamples) / (kPolar * kAzimuth);
  for (std::size_t i = 0; i + 1 < bins.observed.size(); ++i) {
    if (bins.expected[i] < .97 * full) continue;
    observed.push_back(bins.observed[i]);
    expected.push_back(bins.expected[i]);
  }
  EXPECT_GT(observed.size(), 60u);
  return {test::test_chi_squared(observed, expected).p, bins.observed.back() / kSamples,
          bins.expected.back() / kSamples};
}

// 18 tests at level 0.1 % each, 500,000 samples each, seeds 1 .. 18.
TEST(Material, SamplesOfWardDuerFollowTheirDensity) {
  std::uint64_t seed = 0;
  for (float alpha : {.05f, .15f, .5f}) {
    for (double degrees : {0.0, 30.0, 60.0, 80.0, 85.0, 89.0}) {
      const Fit fit = fit_glossy(alpha, degrees, ++seed, 1);
      EXPECT_GT(fit.p, .001) << alpha << " " << degrees;
      EXPECT_NEAR(fit.rejected_observed, fit.rejected_expected, .01) << alpha << " " << degrees;
    }
  }
}

TEST(Material, AMutantDensityWrongByTwoPercentIsCaught) {
  EXPECT_LT(fit_glossy(.15f, 30, 1, 1.02).p, .001);
  EXPECT_LT(fit_glossy(.15f, 30, 1, .98).p, .001);
}

// Directions that sample_glossy rejects must have no density: mixtures with another lobe would otherwise lose
// light there.
TEST(Material, TheGlossyDensityIsZeroWhereSamplesAreRejected) {
  const Vec3 v = direction(80);
  for (double degrees : {90.5, 95.0, 120.0})
    EXPECT_EQ(pdf_glossy(.5f, v, direction(degrees, std::numbers::pi)), 0) << degrees;
  EXPECT_GT(pdf_glossy(.5f, v, direction(85, std::numbers::pi)), 0);
}

TEST(Material, SamplingWeightsAverageToTheAlbedo) {
  const Material material = ward(.15f);
  for (double degrees : {0.0, 45.0, 75.0}) {
    const Vec3 v = direction(degrees);
    RandomStream random(11, "albedo",
                        static_cast<std::uint64_t>(degrees));  // 400,000 samples, four standard errors
    std::vector<double> weights;
    for (int i = 0; i < 400000; ++i) {
      const float u0 = random.next_float(), u1 = random.next_float(), u2 = random.next_float();
      const auto sample = sample_brdf(material, v, u0, u1, u2);
      weights.push_back(sample ? sample->weight.x : 0);
    }
    const auto mean = test::mean_of(weights);
    EXPECT_NEAR(mean.mean, .03 + .22 * lobe_albedo(.15, degrees), 4 * mean.standard_error) << degrees;
  }
}

TEST(Material, LambertianHasNoGlossyLobe) {
  const Material grey = make_material({"", {.19f, .19f, .19f}, {}, 0});
  EXPECT_EQ(grey.glossy_share, 0);
  EXPECT_FLOAT_EQ(eval_brdf(grey, direction(89), direction(10)).x, .19f * kInvPi);
}

}  // namespace
}  // namespace equilux
