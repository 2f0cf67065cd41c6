// VPL light clamped at any level and what the clamp takes make the path-traced light.
#include "renderer/compensation.h"

#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numeric>

#include "renderer/parallel.h"
#include "renderer/shade.h"
#include "tests/renderer/cafe_lights.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

using test::kAllClamps;

struct Case {
  const char* geometry;
  const char* material;
  Emission emission;
};

void PrintTo(const Case& how, std::ostream* stream) {
  *stream << how.geometry << " " << how.material
          << (how.emission == Emission::kFull ? " full emission" : " Lambertian emission");
}

// Points of the object, and which of them lie in the lowest third, about the contact.
struct Stage {
  Scene scene;
  World world;
  Materials materials;
  std::vector<ShadingPoint> points;
  std::vector<bool> near_contact;

  // In the proof room.
  explicit Stage(const Case& how)
      : Stage(load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/proof-room.json"),
              how.geometry, how.material) {}

  Stage(Scene made, const std::string& geometry, const std::string& material)
      : scene(std::move(made)),
        world(make_world(scene, geometry, Illumination::kIndirect)),
        materials(make_materials(world, find_material(scene, material))) {
    const auto all = find_shading_points(trace_primary(world, make_view_camera(scene, 0), 96, 72, 1));
    float top = scene.stand.z;
    for (const ShadingPoint& point : all) top = std::max(top, point.surface.p.z);
    for (std::size_t i = 0; i < all.size(); i += 8) {
      points.push_back(all[i]);
      near_contact.push_back(all[i].surface.p.z < scene.stand.z + 0.3f * (top - scene.stand.z));
    }
  }

  // Mean luminance about the contact or elsewhere.
  double mean_of(const std::vector<double>& light, bool contact) const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < light.size(); ++i) {
      if (near_contact[i] != contact) continue;
      sum += light[i];
      ++count;
    }
    return sum / count;
  }
};

// Means of independent runs, of each level, outside and about the contact.
using Runs = std::vector<std::array<std::vector<double>, 2>>;

Runs make_runs(std::size_t runs) {
  return Runs(kAllClamps.size(), {std::vector<double>(runs), std::vector<double>(runs)});
}

void add_means(const Stage& stage, const std::vector<std::vector<double>>& light, std::size_t run,
               Runs& runs) {
  for (std::size_t level = 0; level < light.size(); ++level) {
    for (std::size_t part : {0u, 1u}) runs[level][part][run] = stage.mean_of(light[level], part == 1);
  }
}

// A run has kTurns sets, each summed at its own part of the points: its VPLs are what varies most. Shadow
// rays are certain for a pair that gives kRouletteShare of `mean`, rarer for the rest.
constexpr std::size_t kTurns = 4;
constexpr double kRouletteShare = .03;

// Luminance at every kTurns-th point. shape: level x point
std::vector<std::vector<double>> sum_set(const Stage& stage, Emission emission, std::size_t set,
                                         double mean) {
  const VplSet traced =
      trace_vpls(stage.world, stage.materials, 4000, 1 + set, "compensation-test", emission);
  VplList vpls = traced.shared;
  vpls.append(traced.own);
  std::vector<ShadingPoint> points;
  for (std::size_t i = set % kTurns; i < stage.points.size(); i += kTurns) points.push_back(stage.points[i]);
  const auto shaded = shade_all_vpls(stage.world, points, vpls, {stage.materials[kObjectMaterial]},
                                     kAllClamps, [](double) {}, {{kRouletteShare * mean}, 1 + set});
  std::vector<std::vector<double>> light(kAllClamps.size());
  for (std::size_t level = 0; level < light.size(); ++level) {
    for (std::size_t i = 0; i < points.size(); ++i)
      light[level].push_back(luminance(shaded.radiance[shaded.index(0, level, i)]));
  }
  return light;
}

Runs sum_vpls(const Stage& stage, Emission emission, std::size_t count, double mean) {
  Runs runs = make_runs(count);
  for_each_parallel(count, [&](std::size_t run) {
    std::vector<std::vector<double>> light(kAllClamps.size(), std::vector<double>(stage.points.size()));
    for (std::size_t turn = 0; turn < kTurns; ++turn) {
      const auto some = sum_set(stage, emission, run * kTurns + turn, mean);
      for (std::size_t level = 0; level < light.size(); ++level) {
        for (std::size_t i = 0; i < some[level].size(); ++i) light[level][turn + i * kTurns] = some[level][i];
      }
    }
    add_means(stage, light, run, runs);
  });
  return runs;
}

Runs trace_runs(const Stage& stage, std::size_t count, int paths, const std::string& stream,
                const std::function<void(const ShadingPoint&, PathSampler&, std::vector<double>&)>& add) {
  Runs runs = make_runs(count);
  const StreamKey key = make_stream_key(1, stream);
  for_each_parallel(count, [&](std::size_t run) {
    std::vector<std::vector<double>> light(kAllClamps.size(), std::vector<double>(stage.points.size()));
    for (std::size_t i = 0; i < stage.points.size(); ++i) {
      PathSampler sampler(RandomStream(key, i * count + run));
      std::vector<double> sums(kAllClamps.size());
      for (int path = 0; path < paths; ++path) {
        sampler.next_path();
        add(stage.points[i], sampler, sums);
      }
      for (std::size_t level = 0; level < sums.size(); ++level) light[level][i] = sums[level] / paths;
    }
    add_means(stage, light, run, runs);
  });
  return runs;
}

Runs trace_returned(const Stage& stage, const ReturnParams& params, std::size_t count) {
  return trace_runs(stage, count, 160, "returned",
                    [&](const ShadingPoint& point, PathSampler& sampler, std::vector<double>& sums) {
                      const ReturnedLight light = estimate_returned(stage.world, stage.materials,
                                                                    point.surface, point.v, params, sampler);
                      for (std::size_t level = 0; level < sums.size(); ++level)
                        sums[level] += luminance(light.at(kAllClamps[level]));
                    });
}

Runs trace_all(const Stage& stage, std::size_t count) {
  return trace_runs(stage, count, 160, "all",
                    [&](const ShadingPoint& point, PathSampler& sampler, std::vector<double>& sums) {
                      const double light = luminance(estimate_reflected(
                          stage.world, stage.materials, point.surface, point.v, false, sampler));
                      for (double& sum : sums) sum += light;
                    });
}

// Of clamped plus returned light from all light, in standard errors.
struct Difference {
  double relative, standard_error;
  double z() const { return std::abs(relative / standard_error); }
};

Difference compare(const std::vector<double>& clamped, const std::vector<double>& returned,
                   const std::vector<double>& all) {
  const test::Mean a = test::mean_of(clamped), b = test::mean_of(returned), c = test::mean_of(all);
  return {(a.mean + b.mean) / c.mean - 1,
          std::hypot(a.standard_error, b.standard_error, c.standard_error) / c.mean};
}

class ClampedLight : public testing::TestWithParam<Case> {};

constexpr std::size_t kRunsOfVpls = 96, kFewRuns = 24, kBatchesOfPaths = 48, kFewBatches = 24;
// Level 1 % over five cases of 18 comparisons, two-sided.
const double kMostErrors =
    boost::math::quantile(boost::math::complement(boost::math::normal(), .01 / 5 / 18 / 2));
constexpr std::size_t kFirstAtContact = 4;  // above it the unclamped sum's variance diverges there

// Seeds 1 to 384, four to a run, and 48 randomisations of 160 paths at each of 200 points and more. A bias of
// 2 % is seen with 90 % power, of 4 % about the contact.
TEST_P(ClampedLight, PlusWhatTheClampTakesIsThePathTracersAtEveryLevel) {
  const Stage stage(GetParam());
  const bool with_missing = GetParam().emission == Emission::kLambertian && has_gloss(stage.materials);
  const Runs all = trace_all(stage, kBatchesOfPaths),
             clamped = sum_vpls(stage, GetParam().emission, kRunsOfVpls, test::mean_of(all[0][0]).mean),
             returned = trace_returned(stage, {0, with_missing}, kBatchesOfPaths);
  for (std::size_t level = 0; level < kAllClamps.size(); ++level) {
    for (std::size_t part : {0u, 1u}) {
      if (part == 1 && level < kFirstAtContact) continue;
      const Difference difference = compare(clamped[level][part], returned[level][part], all[level][part]);
      const std::string text = fmt::format("C{} {}: {:.4f} +- {:.4f}", level, part == 1 ? "contact" : "rest",
                                           difference.relative, difference.standard_error);
      EXPECT_LT(difference.z(), kMostErrors) << text;
      EXPECT_LT(difference.standard_error, (part == 1 ? 0.04 : 0.02) / (kMostErrors + 1.28)) << text;
    }
  }
  // Something is taken and given back.
  EXPECT_GT(test::mean_of(returned[10][0]).mean, 0.1 * test::mean_of(all[10][0]).mean);
}

INSTANTIATE_TEST_SUITE_P(Cases, ClampedLight,
                         testing::Values(Case{"G0", "MS", Emission::kLambertian},
                                         Case{"G2", "MR", Emission::kLambertian},
                                         Case{"G2", "MR", Emission::kFull},
                                         Case{"G2", "GS", Emission::kLambertian},
                                         Case{"G3", "LG", Emission::kFull}),
                         [](const auto& row) {
                           return fmt::format("{}{}{}", row.param.geometry, row.param.material,
                                              row.param.emission == Emission::kFull ? "Full" : "Lambertian");
                         });

// Mutant: what is given back belongs to the next level.
TEST(ClampedLight, AMutantThatGivesBackForAnotherLevelIsCaught) {
  const Stage stage({"G2", "MR", Emission::kFull});
  const Runs all = trace_all(stage, kFewBatches),
             clamped = sum_vpls(stage, Emission::kFull, kFewRuns, test::mean_of(all[0][0]).mean),
             returned = trace_returned(stage, {0, false}, kFewBatches);
  for (std::size_t level = 4; level < 8; ++level) {
    EXPECT_LT(compare(clamped[level][1], returned[level][1], all[level][1]).z(), kMostErrors) << level;
    EXPECT_GT(compare(clamped[level][1], returned[level + 1][1], all[level][1]).z(), kMostErrors) << level;
  }
}

// A rough metal wall lights a grey ball: most of what its VPLs lack with Lambertian emission comes from
// gloss. Mutant: it is not given back.
TEST(ClampedLight, AMutantWithoutWhatEmissionLacksIsCaught) {
  const Stage stage(test::make_metal_wall_scene(), "G0", "grey");
  const Runs all = trace_all(stage, kFewBatches),
             clamped = sum_vpls(stage, Emission::kLambertian, kFewRuns, test::mean_of(all[0][0]).mean);
  const auto z = [&](bool with_missing, std::size_t level) {
    const Runs returned = trace_returned(stage, {0, with_missing}, kFewBatches);
    return compare(clamped[level][0], returned[level][0], all[level][0]).z();
  };
  for (std::size_t level : {0u, 4u, 8u}) {
    EXPECT_LT(z(true, level), kMostErrors) << level;
    EXPECT_GT(z(false, level), kMostErrors) << level;
  }
}

// First rays that end where the least clamp takes nothing bring the same light as whole ones.
TEST(ClampedLight, IsTheSameByShortRaysAndByWholeOnes) {
  const Stage stage({"G2", "MR", Emission::kFull});
  const Runs whole = trace_returned(stage, {0, false}, kBatchesOfPaths),
             brief = trace_returned(stage, {kAllClamps[4], false}, kBatchesOfPaths);
  for (std::size_t level = 0; level <= 4; ++level) {
    for (std::size_t part : {0u, 1u}) {
      const test::Mean a = test::mean_of(whole[level][part]), b = test::mean_of(brief[level][part]);
      EXPECT_LE(std::abs(a.mean - b.mean), kMostErrors * std::hypot(a.standard_error, b.standard_error))
          << level << " " << part;
    }
  }
}

// A layer for each clamp, from the same paths on any number of threads: what comes back grows as the clamp
// gets stricter, and is nothing where there is none.
TEST(CompensationLayers, AreTheSameOnOneAndTwoThreadsAndGrowWithTheClamp) {
  const Stage stage({"G2", "MR", Emission::kFull});
  const Primary primary = trace_primary(stage.world, make_view_camera(stage.scene, 0), 32, 24, 2);
  const FamilyScene scene{stage.world, stage.materials, primary};
  const PathMap map(32 * 24, 4);
  const CompensationParams params{kAllClamps, Emission::kFull, 1, "layers", {}};
  std::vector<std::vector<TracedLayer>> runs;
  for (int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    runs.push_back(trace_compensation(scene, map, params, [](double) {}));
  }
  const HdrImage coverage = make_coverage(primary);
  for (std::size_t level = 0; level < kAllClamps.size(); ++level) {
    EXPECT_EQ(runs[0][level].mean.values, runs[1][level].mean.values);
    EXPECT_EQ(runs[0][level].standard_error.values, runs[1][level].standard_error.values);
    double sum = 0;
    for (std::size_t i = 0; i < coverage.pixel_count(); ++i) {
      const float* light = runs[0][level].mean.pixel(i);
      const float* before = runs[0][std::max<std::size_t>(1, level) - 1].mean.pixel(i);
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_GE(light[c], before[c]);
        ASSERT_TRUE(coverage.values[i] > 0 || light[c] == 0);
        sum += light[c];
      }
    }
    EXPECT_EQ(sum > 0, level > 0) << level;
  }
}

// Mean over the points of what VPL sums vary by from set to set, of each level: luminance.
std::vector<double> measure_variances(const Stage& stage, std::size_t sets, std::int64_t paths) {
  std::vector<std::vector<double>> sums(kAllClamps.size(), std::vector<double>(stage.points.size())),
      squares = sums;
  for (std::size_t set = 0; set < sets; ++set) {
    const VplList vpls = join_vpls(trace_vpls(stage.world, stage.materials, paths, 1 + set, "variance"));
    const auto shaded = shade_all_vpls(stage.world, stage.points, vpls, {stage.materials[kObjectMaterial]},
                                       kAllClamps, [](double) {});
    for (std::size_t level = 0; level < sums.size(); ++level) {
      for (std::size_t i = 0; i < stage.points.size(); ++i) {
        const double light = luminance(shaded.radiance[shaded.index(0, level, i)]);
        sums[level][i] += light;
        squares[level][i] += light * light;
      }
    }
  }
  std::vector<double> variances(sums.size());
  const auto count = static_cast<double>(sets);
  for (std::size_t level = 0; level < sums.size(); ++level) {
    for (std::size_t i = 0; i < stage.points.size(); ++i)
      variances[level] += (squares[level][i] - sums[level][i] * sums[level][i] / count) / (count - 1) /
                          static_cast<double>(stage.points.size());
  }
  return variances;
}

// Variance beyond that of the hardest clamp, as compensation's paths foresee it over what independent sets
// show, of C5 to C8.
std::vector<double> compare_variances(const Stage& stage) {
  constexpr std::int64_t kPaths = 1500;
  const std::vector<double> seen = measure_variances(stage, 32, kPaths);
  const Primary primary = trace_primary(stage.world, make_view_camera(stage.scene, 0), 96, 72, 1);
  CompensationRecord record;
  trace_compensation(
      {stage.world, stage.materials, primary}, PathMap(96 * 72, 16),
      {kAllClamps, Emission::kLambertian, 1, "variance", {}}, [](double) {}, &record);
  std::vector<SurfacePoint> points;
  for (std::size_t i = 0; i < stage.points.size(); i += 8) points.push_back(stage.points[i].surface);
  const std::array<double, 3> intensity =
      measure_intensity(join_vpls(trace_vpls(stage.world, stage.materials, kPaths, 1, "variance")), points);
  const auto foresee = [&](std::size_t level) {
    double sum = 0;
    for (const ShadingPoint& point : stage.points) {
      const float* of_pixel = record.variances[level].pixel(point.pixel);
      // Of a luminance, as if all channels came together.
      sum += luminance({static_cast<float>(intensity[0] * of_pixel[0]),
                        static_cast<float>(intensity[1] * of_pixel[1]),
                        static_cast<float>(intensity[2] * of_pixel[2])});
    }
    return sum / static_cast<double>(stage.points.size());
  };
  std::vector<double> ratios;
  for (std::size_t level = 5; level < 9; ++level)
    ratios.push_back((foresee(level) - foresee(10)) / (seen[level] - seen[10]));
  return ratios;
}

// What compensation's paths foresee of VPLs that are near is what independent sets show, level over level.
// Two fifths are allowed: intensities differ from place to place, and sets are few.
TEST(CompensationRecord, ForeseesTheVarianceOfVplsThatTheClampActsOn) {
  const Scene cafe = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  for (const char* material : {"MS", "GS"}) {
    for (const double ratio : compare_variances(Stage(cafe, "G0", material)))
      EXPECT_NEAR(ratio, 1, 0.4) << material;
  }
}

// In the proof room it foresees half as much again, at every level alike: why is not known. Too much costs
// time alone.
TEST(CompensationRecord, ForeseesMoreVarianceThanThereIsInTheProofRoom) {
  for (const double ratio : compare_variances(Stage({"G2", "MS", Emission::kLambertian}))) {
    EXPECT_GT(ratio, 1);
    EXPECT_LT(ratio, 2);
  }
}

// Paths go on where the clamp acts or gloss is met, whatever other levels are asked for.
TEST(CompensationRecord, CountsPathsThatGoOn) {
  const auto count = [](const char* material, Emission emission, std::vector<double> clamps) {
    const Stage stage({"G2", material, emission});
    const Primary primary = trace_primary(stage.world, make_view_camera(stage.scene, 0), 48, 36, 2);
    CompensationRecord record;
    trace_compensation(
        {stage.world, stage.materials, primary}, PathMap(48 * 36, 8),
        {std::move(clamps), emission, 1, "count", {}}, [](double) {}, &record);
    return record.walked;
  };
  const std::vector<double> whole = count("MR", Emission::kFull, kAllClamps),
                            lacking = count("MR", Emission::kLambertian, kAllClamps);
  EXPECT_EQ(whole[0], 0);
  EXPECT_GT(lacking[0], 0);
  EXPECT_GT(whole[10], 0.1);
  for (std::size_t level = 1; level < whole.size(); ++level) {
    EXPECT_GE(whole[level], whole[level - 1]);
    EXPECT_GE(lacking[level], whole[level]);
    EXPECT_LE(lacking[level], 1);
  }
  for (std::size_t level : {5u, 8u}) {
    EXPECT_NEAR(count("MR", Emission::kFull, {kAllClamps[level]})[0], whole[level], 0.02) << level;
    EXPECT_NEAR(count("MR", Emission::kLambertian, {kAllClamps[level]})[0], lacking[level], 0.02) << level;
  }
}

}  // namespace
}  // namespace equilux
