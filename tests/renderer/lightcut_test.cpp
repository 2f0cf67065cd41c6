// Cuts against the plain sum over all VPLs, in the café.
#include "renderer/lightcut.h"

#include <gtest/gtest.h>
#include <limits>

#include "base/error.h"
#include "renderer/cut_groups.h"
#include "renderer/isa.h"
#include "tests/renderer/cafe_lights.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

using test::Cafe;
using test::kAllClamps;
using ShadeLightcut = decltype(&shade_lightcut);

class Lightcut : public testing::TestWithParam<ShadeLightcut> {};
INSTANTIATE_TEST_SUITE_P(ScalarAndFast, Lightcut, testing::Values(&shade_lightcut_scalar, &shade_lightcut),
                         [](const auto& code) { return std::string(code.index == 0 ? "Scalar" : "Fast"); });

// Down to the leaves nothing is estimated: what differs is float's rounding, in two codes of their own.
TEST_P(Lightcut, OfRatioZeroIsThePlainSum) {
  for (const Emission emission : {Emission::kLambertian, Emission::kFull}) {
    const Cafe cafe("G2", 61, 1500, emission);
    const ShadedPoints sum = cafe.sum(kAllClamps);
    CutRecord record;
    const LightTree tree = make_light_tree(cafe.vpls, {1, 1});
    const ShadedPoints cut =
        GetParam()(cafe.world, cafe.points, tree, cafe.materials, kAllClamps, {0, 0}, &record);
    ASSERT_EQ(sum.radiance.size(), cut.radiance.size());
    for (std::size_t i = 0; i < sum.radiance.size(); ++i) {
      for (const auto& [a, b] : {std::pair{sum.radiance[i].x, cut.radiance[i].x},
                                 {sum.radiance[i].y, cut.radiance[i].y},
                                 {sum.radiance[i].z, cut.radiance[i].z}})
        ASSERT_NEAR(b / a, 1, 2e-4) << i;
    }
    EXPECT_GT(record.shadow_rays, cafe.points.size() * 100);
  }
}

// Relative errors of luminance at 22,000 VPLs, ratio .75 %, for each material and level.
TEST_P(Lightcut, IsWithinItsErrorOfThePlainSumForEveryMaterialAndLevel) {
  const Cafe cafe("G2", 12, 6000, Emission::kLambertian);
  const ShadedPoints sum = cafe.sum(kAllClamps);
  CutRecord record;
  const ShadedPoints cut = cafe.cut(GetParam(), kAllClamps, 0.0075, 1, &record);
  for (std::size_t m = 0; m < cafe.materials.size(); ++m) {
    for (std::size_t level = 0; level < kAllClamps.size(); ++level) {
      double squares = 0;
      std::vector<double> errors;
      for (std::size_t i = 0; i < cafe.points.size(); ++i) {
        const double truth = luminance(sum.radiance[sum.index(m, level, i)]),
                     found = luminance(cut.radiance[cut.index(m, level, i)]);
        errors.push_back(std::abs(found - truth) / (truth + 1e-5));
        squares += errors.back() * errors.back();
      }
      std::sort(errors.begin(), errors.end());
      EXPECT_LT(std::sqrt(squares / static_cast<double>(errors.size())), 0.02) << m << " C" << level;
      EXPECT_LT(errors[errors.size() * 99 / 100], 0.06) << m << " C" << level;
    }
  }
  double mean = 0;
  for (std::uint32_t size : record.sizes) mean += size / static_cast<double>(record.sizes.size());
  EXPECT_LT(mean, 0.25 * static_cast<double>(cafe.vpls.size()));
  RecordProperty("mean_cut", std::to_string(mean));
}

// A single level by its own rule, and out of eleven: both within the rule, the latter at no less care.
TEST_P(Lightcut, OfAllLevelsAtOnceIsNoWorseThanOfOne) {
  const Cafe cafe("G0", 24, 6000, Emission::kLambertian, {"MS"});
  for (std::size_t level : {0u, 4u, 8u}) {
    const std::vector<double> one{kAllClamps[level]};
    const ShadedPoints sum = cafe.sum(one);
    CutRecord alone_record, all_record;
    const ShadedPoints alone = cafe.cut(GetParam(), one, 0.0075, 1, &alone_record),
                       all = cafe.cut(GetParam(), kAllClamps, 0.0075, 1, &all_record);
    double alone_squares = 0, all_squares = 0;
    for (std::size_t i = 0; i < cafe.points.size(); ++i) {
      const double truth = luminance(sum.radiance[i]) + 1e-5;
      alone_squares += std::pow((luminance(alone.radiance[i]) - truth + 1e-5) / truth, 2);
      all_squares += std::pow((luminance(all.radiance[all.index(0, level, i)]) - truth + 1e-5) / truth, 2);
    }
    EXPECT_LT(all_squares, 1.2 * alone_squares) << "C" << level;
    for (std::size_t i = 0; i < cafe.points.size(); ++i)
      ASSERT_GE(all_record.sizes[i] * 1.1, alone_record.sizes[i]);
  }
}

// All levels have one cut, so its order holds exactly, but for rounding: a harder clamp never brightens.
TEST_P(Lightcut, OfLessClampIsNeverDarker) {
  const Cafe cafe("G2", 12, 6000, Emission::kLambertian);
  const ShadedPoints cut = cafe.cut(GetParam(), kAllClamps, 0.0075, 1);
  std::size_t darker = 0;
  for (std::size_t m = 0; m < cafe.materials.size(); ++m) {
    for (std::size_t level = 1; level < kAllClamps.size(); ++level) {
      for (std::size_t i = 0; i < cafe.points.size(); ++i) {
        const Vec3 less = cut.radiance[cut.index(m, level - 1, i)],
                   more = cut.radiance[cut.index(m, level, i)];
        ASSERT_LE(luminance(more), luminance(less) * (1 + 1e-5f)) << m << " C" << level << " at " << i;
        darker += luminance(more) < luminance(less);
      }
    }
  }
  EXPECT_GT(darker, cafe.points.size()) << "clamping takes something somewhere";
}

// 300 seeds of the tree at a coarse ratio, 12 points, each channel and three levels. With totals known
// beforehand: level .01 over all 9 by Bonferroni. With the cut's own, which depend on the representatives, a
// bias is left: under a tenth of the ratio.
TEST_P(Lightcut, IsUnbiasedOverTreeSeedsInEveryChannel) {
  const Cafe cafe("G2", 180, 1500, Emission::kFull, {"MR"});
  const std::vector<double> clamps{kAllClamps[0], kAllClamps[4], kAllClamps[8]};
  constexpr int kSeeds = 300;
  for (const bool adaptive : {false, true}) {
    for (double clamp : clamps) {
      const ShadedPoints sum = cafe.sum({clamp});
      std::array<std::vector<double>, 3> ratios;
      for (int seed = 0; seed < kSeeds; ++seed) {
        const LightTree tree = make_light_tree(cafe.vpls, {static_cast<std::uint64_t>(seed), 1});
        const LightcutParams params{0.05, 1e-5, adaptive ? nullptr : &sum, adaptive};
        const ShadedPoints cut =
            GetParam()(cafe.world, cafe.points, tree, cafe.materials, {clamp}, params, nullptr);
        Vec3 found, truth;
        for (std::size_t i = 0; i < cafe.points.size(); ++i) {
          found += cut.radiance[i];
          truth += sum.radiance[i];
        }
        ratios[0].push_back(found.x / truth.x);
        ratios[1].push_back(found.y / truth.y);
        ratios[2].push_back(found.z / truth.z);
      }
      for (const auto& channel : ratios) {
        const test::Mean mean = test::mean_of(channel);
        const double allowed = 3.3 * mean.standard_error + (adaptive ? 0.005 : 0);
        EXPECT_LT(std::abs(mean.mean - 1), allowed) << mean.mean << " c " << clamp << " " << adaptive;
        EXPECT_LT(mean.standard_error, 0.004);
      }
    }
  }
}

// What the study needs of its scene: on smooth metal the levels go from no change to nearly black (what is
// left is the diffuse seventh), and C4 takes the contact's reflections and some of the silhouette's while the
// middle, which mirrors the walls, keeps its own.
TEST(Cafe, LosesLightOnSmoothMetalFromNoneToNearlyAllAndAtC4AboutTheContact) {
  const Cafe cafe("G0", 3, 300000, Emission::kLambertian, {"MS"}, Illumination::kIndirect);
  const ShadedPoints cut = cafe.cut(&shade_lightcut, kAllClamps, 0.0075, 1, nullptr, 4);
  // Light of all points, of those in the lowest third of the ball, at silhouettes, and facing the camera.
  std::vector<std::array<double, 4>> light(kAllClamps.size());
  for (std::size_t level = 0; level < light.size(); ++level) {
    for (std::size_t i = 0; i < cafe.points.size(); ++i) {
      const double value = luminance(cut.radiance[cut.index(0, level, i)]);
      const float height = cafe.points[i].surface.p.z - 0.4f,
                  cosine = dot(cafe.points[i].surface.ns, cafe.points[i].v);
      light[level][0] += value;
      if (height < 0.3f) light[level][1] += value;
      if (height > 0.45f && cosine < 0.15f) light[level][2] += value;
      if (cosine > 0.8f) light[level][3] += value;
    }
  }
  const auto left = [&](std::size_t level, std::size_t part) { return light[level][part] / light[0][part]; };
  for (std::size_t level = 1; level < light.size(); ++level) EXPECT_LE(left(level, 0), left(level - 1, 0));
  EXPECT_GT(left(1, 0), 0.98);
  EXPECT_LT(left(4, 1), 0.8) << "contact";
  EXPECT_LT(left(4, 2), 0.85) << "silhouettes";
  EXPECT_GT(left(4, 3), 0.99) << "middle";
  EXPECT_LT(left(8, 0), 0.5);
  EXPECT_LT(left(10, 0), 0.2);
}

// Two codes of one rule: cuts of nearly one size (the fast one starts from its neighbour's thresholds), light
// within what the rule leaves open.
TEST(Lightcuts, OfBothCodesAgree) {
  for (const Emission emission : {Emission::kLambertian, Emission::kFull}) {
    const Cafe cafe("G2", 24, 6000, emission, {"MS"});
    CutRecord scalar_record, fast_record;
    const ShadedPoints scalar = cafe.cut(&shade_lightcut_scalar, kAllClamps, 0.0075, 1, &scalar_record, 4),
                       fast = cafe.cut(&shade_lightcut, kAllClamps, 0.0075, 1, &fast_record, 4);
    double scalar_size = 0, fast_size = 0, squares = 0;
    for (std::size_t i = 0; i < cafe.points.size(); ++i) {
      scalar_size += scalar_record.sizes[i];
      fast_size += fast_record.sizes[i];
    }
    EXPECT_LT(fast_size, 1.05 * scalar_size);
    EXPECT_GT(fast_size, 0.8 * scalar_size);
    for (std::size_t i = 0; i < scalar.radiance.size(); ++i) {
      const double a = luminance(scalar.radiance[i]), b = luminance(fast.radiance[i]);
      squares += std::pow((b - a) / (a + 1e-5), 2) / static_cast<double>(scalar.radiance.size());
    }
    EXPECT_LT(std::sqrt(squares), 0.01);
  }
}

// Samples of a pixel share a cut, each by its own rule, whatever their number and wherever they lie.
TEST(Lightcuts, OfSamplesOfAPixelKeepTheRuleOfEachSample) {
  for (const std::size_t samples : {2u, 3u, 4u, 7u, 16u, 23u}) {
    Cafe cafe("G2", 24, 3000, Emission::kLambertian, {"MS", "GS"});
    const ShadedPoints sum = cafe.sum(kAllClamps);
    for (std::size_t i = 0; i < cafe.points.size(); ++i)
      cafe.points[i].pixel = static_cast<std::uint32_t>(i / samples);
    const ShadedPoints all = cafe.cut(&shade_lightcut, kAllClamps, 0, 1),
                       cut = cafe.cut(&shade_lightcut, kAllClamps, 0.0075, 1, nullptr, 4);
    double squares = 0, worst = 0;
    for (std::size_t i = 0; i < sum.radiance.size(); ++i) {
      const double truth = luminance(sum.radiance[i]);
      ASSERT_NEAR(luminance(all.radiance[i]), truth, 2e-4 * truth) << samples << " at " << i;
      const double error = std::abs(luminance(cut.radiance[i]) - truth) / (truth + 1e-5);
      squares += error * error / static_cast<double>(sum.radiance.size());
      worst = std::max(worst, error);
    }
    EXPECT_LT(std::sqrt(squares), 0.015) << samples;
    EXPECT_LT(worst, 0.1) << samples;
  }
}

// As far apart as they may be, samples that walk together find the cuts that each finds alone, of as many
// clusters and rays. Totals known beforehand, or the cut's own, which take several rounds.
TEST(Lightcuts, OfSamplesOfAPixelAreThoseOfEachAlone) {
  const Isa before = current_isa();
  for (const Isa isa : {Isa::kV3, Isa::kV4}) {
    if (!has_isa(isa)) continue;
    fix_isa(isa);
    for (const Emission emission : {Emission::kLambertian, Emission::kFull}) {
      const Cafe cafe("G2", 130, 3000, emission, {"MR", "LG"});
      const LightTree tree = make_light_tree(cafe.vpls, {1, 4});
      const ShadedPoints sum = cafe.sum(kAllClamps);
      for (const bool adaptive : {false, true}) {
        for (const std::size_t samples : {2u, 3u, 4u, 7u, 16u}) {
          std::vector<ShadingPoint> points(cafe.points.begin(), cafe.points.begin() + samples);
          const auto cut = [&](std::size_t first, std::size_t count, CutRecord& record) {
            ShadedPoints base{sum.levels, count, {}, 0};
            for (std::size_t m = 0; m < cafe.materials.size(); ++m) {
              for (std::size_t level = 0; level < sum.levels; ++level) {
                for (std::size_t i = 0; i < count; ++i)
                  base.radiance.push_back(sum.radiance[sum.index(m, level, first + i)]);
              }
            }
            const std::vector<ShadingPoint> some(&points[first], &points[first] + count);
            const LightcutParams params{0.01, 1e-5, adaptive ? nullptr : &base, adaptive};
            return shade_lightcut(cafe.world, some, tree, cafe.materials, kAllClamps, params, &record);
          };
          for (ShadingPoint& point : points) point.pixel = 0;
          CutRecord together;
          const ShadedPoints light = cut(0, samples, together);
          std::uint64_t rays = 0;
          for (std::size_t i = 0; i < samples; ++i) {
            CutRecord alone;
            const ShadedPoints own = cut(i, 1, alone);
            rays += alone.shadow_rays;
            EXPECT_EQ(together.sizes[i], alone.sizes[0]) << samples << " at " << i;
            EXPECT_GT(alone.sizes[0], 256u);
            for (std::size_t m = 0; m < cafe.materials.size(); ++m) {
              for (std::size_t level = 0; level < sum.levels; ++level) {
                const double truth = luminance(own.radiance[own.index(m, level, 0)]);
                EXPECT_NEAR(luminance(light.radiance[light.index(m, level, i)]), truth, 1e-5 * truth)
                    << samples << " at " << i << " " << m << " C" << level;
              }
            }
          }
          EXPECT_EQ(together.shadow_rays, rays) << samples;
        }
      }
    }
  }
  fix_isa(before);
}

// Points of a picture, each in a pixel of its own, as a set sees them.
TEST(Lightcuts, OfNeighboursAreThoseOfEachAlone) {
  const Cafe cafe("G2", 130, 3000, Emission::kLambertian, {"GS"});
  const LightTree tree = make_light_tree(cafe.vpls, {1, 4});
  const std::vector<double> clamp{clamp_per_m2(5)};
  const ShadedPoints base = cafe.sum(clamp);
  const auto cut = [&](std::size_t neighbours, CutRecord& record) {
    return shade_lightcut(cafe.world, cafe.points, tree, cafe.materials, clamp,
                          {0.01, 1e-5, &base, false, neighbours}, &record);
  };
  CutRecord alone, together;
  const ShadedPoints one = cut(0, alone), all = cut(16, together);
  ASSERT_GT(one.points, 16u);
  EXPECT_EQ(alone.sizes, together.sizes);
  EXPECT_EQ(alone.shadow_rays, together.shadow_rays);
  for (std::size_t i = 0; i < one.radiance.size(); ++i) {
    const double light = luminance(one.radiance[i]);
    EXPECT_NEAR(luminance(all.radiance[i]), light, 1e-5 * light) << i;
  }
}

TEST(CutGroups, AreThePixelsSamplesOrSoManyNeighbours) {
  std::vector<ShadingPoint> points(23);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].pixel = static_cast<std::uint32_t>(i / 2);
  const auto counts = [&](std::size_t most, std::size_t neighbours) {
    std::vector<std::size_t> found;
    for (const PointRange& group : group_points(points, most, neighbours)) found.push_back(group.count);
    return found;
  };
  EXPECT_EQ(counts(16, 0), (std::vector<std::size_t>{2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 1}));
  EXPECT_EQ(counts(1, 0), std::vector<std::size_t>(23, 1));
  EXPECT_EQ(counts(16, 16), (std::vector<std::size_t>{16, 7}));
  EXPECT_EQ(counts(16, 9), (std::vector<std::size_t>{9, 9, 5}));
  EXPECT_EQ(counts(16, 40), (std::vector<std::size_t>{16, 7}));
}

// One rule for all materials: as good for each as a cut of its own, and shorter than all those together.
// Errors over four tree seeds: one tree's may be half as large again as another's.
TEST(Lightcuts, OfSeveralMaterialsKeepTheRuleOfEach) {
  const Cafe cafe("G0", 24, 6000, Emission::kLambertian, {"MS", "MR", "BS", "BR", "GS", "LG"});
  const ShadedPoints sum = cafe.sum(kAllClamps);
  Cafe one("G0", 24, 6000, Emission::kLambertian, {"MS"});
  double separately = 0, joint = 0;
  std::vector<double> squares(cafe.materials.size()), own_squares(cafe.materials.size());
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    CutRecord together;
    const ShadedPoints cut = cafe.cut(&shade_lightcut, kAllClamps, 0.0075, seed, &together, 4);
    joint += static_cast<double>(together.shadow_rays);
    for (std::size_t m = 0; m < cafe.materials.size(); ++m) {
      one.materials = {cafe.materials[m]};
      CutRecord record;
      const ShadedPoints own = one.cut(&shade_lightcut, kAllClamps, 0.0075, seed, &record, 4);
      separately += static_cast<double>(record.shadow_rays);
      for (std::size_t level = 0; level < kAllClamps.size(); ++level) {
        for (std::size_t i = 0; i < cafe.points.size(); ++i) {
          const double truth = luminance(sum.radiance[sum.index(m, level, i)]) + 1e-5;
          const auto square = [&](Vec3 light) { return std::pow((luminance(light) + 1e-5) / truth - 1, 2); };
          squares[m] += square(cut.radiance[cut.index(m, level, i)]);
          own_squares[m] += square(own.radiance[own.index(0, level, i)]);
        }
      }
    }
  }
  for (std::size_t m = 0; m < squares.size(); ++m) EXPECT_LT(squares[m], 1.2 * own_squares[m]) << m;
  EXPECT_LT(joint, 0.6 * separately);
}

TEST(Isa, HasTwoNamesAndRefusesOthers) {
  for (const Isa isa : {Isa::kV3, Isa::kV4}) EXPECT_EQ(parse_isa(format_isa(isa), "--isa"), isa);
  EXPECT_THROW(parse_isa("avx2", "--isa"), InputError);
  EXPECT_TRUE(has_isa(current_isa()));
}

// What is chosen at the start changes no more than rounding, and what that tips.
TEST(Lightcuts, OfBothInstructionSetsAgree) {
  if (!has_isa(Isa::kV4)) GTEST_SKIP() << "this processor has one";
  const Isa before = current_isa();
  for (const Emission emission : {Emission::kLambertian, Emission::kFull}) {
    const Cafe cafe("G2", 24, 3000, emission);
    std::vector<ShadedPoints> sums, all, cuts;
    for (const Isa isa : {Isa::kV3, Isa::kV4}) {
      fix_isa(isa);
      sums.push_back(cafe.sum(kAllClamps));
      all.push_back(cafe.cut(&shade_lightcut, kAllClamps, 0, 1));
      cuts.push_back(cafe.cut(&shade_lightcut, kAllClamps, 0.0075, 1));
    }
    double squares = 0;
    for (std::size_t i = 0; i < sums[0].radiance.size(); ++i) {
      const double sum = luminance(sums[0].radiance[i]), scale = sum + 1e-5;
      ASSERT_NEAR(luminance(sums[1].radiance[i]), sum, 2e-4 * scale) << i;
      ASSERT_NEAR(luminance(all[1].radiance[i]), luminance(all[0].radiance[i]), 2e-4 * scale) << i;
      squares += std::pow((luminance(cuts[1].radiance[i]) - luminance(cuts[0].radiance[i])) / scale, 2);
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(sums[0].radiance.size())), 2e-3);
  }
  fix_isa(before);
}

}  // namespace
}  // namespace equilux
