// Error against run time: figures whose values are known, and whole runs on a small room.
#include "renderer/converge.h"

#include <gtest/gtest.h>
#include <sstream>

#include "base/error.h"
#include "base/random.h"
#include "renderer/converge_error.h"
#include "renderer/converge_format.h"
#include "renderer/converge_plot.h"
#include "tests/renderer/test_scene.h"

namespace equilux {
namespace {

double draw_normal(RandomStream& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.next_double();
  return sum;
}

// 40 x 30 pixels, the left half the object's, radiance 1, a reference with noise of this size.
TruthLayers make_layers(double noise, RandomStream& random) {
  TruthLayers layers;
  const HdrImage black(40, 30);
  layers.background = layers.direct = black;
  layers.coverage = HdrImage(40, 30, 1);
  layers.indirect = {black, black};
  for (std::size_t i = 0; i < black.pixel_count(); ++i) {
    const bool object = i % 40 < 20;
    layers.coverage.values[i] = object ? 1 : 0;
    for (std::size_t c = 0; c < 3; ++c) {
      if (object) layers.indirect.mean.pixel(i)[c] = static_cast<float>(1 + noise * draw_normal(random));
      if (object) layers.indirect.standard_error.pixel(i)[c] = static_cast<float>(noise);
      if (!object) layers.background.pixel(i)[c] = 1;
    }
  }
  layers.tone =
      make_tone_curve(composite({&layers.background, &layers.indirect.mean}), layers.coverage, ToneMapping{});
  return layers;
}

HdrImage make_picture_with(const TruthLayers& layers, double mean, double noise, RandomStream& random) {
  HdrImage picture = layers.indirect.mean;
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      picture.pixel(i)[c] =
          layers.coverage.values[i] > 0 ? static_cast<float>(mean + noise * draw_normal(random)) : 0;
  }
  return picture;
}

// 600 pixels x 3 channels x 8 runs: a bias of -4 % and noise of 3 % are .05 rms, though the reference's own
// noise is as large as 5 %.
TEST(ConvergeError, IsThatOfThePictureNotOfTheReference) {
  RandomStream random(1, "converge-error", 0);
  const ReferenceTruth truth(make_layers(0.05, random), "test");
  EXPECT_NEAR(truth.rms_of_error(), 0.05, 1e-3);
  EXPECT_EQ(truth.object_pixels(), 600u);
  std::vector<RunError> runs;
  for (int run = 0; run < 8; ++run)
    runs.push_back(truth.compare(make_picture_with(truth.layers(), 0.96, 0.03, random)));
  const ErrorFigures figures = summarise_runs(runs, truth.error_of_mean());
  EXPECT_NEAR(figures.relative_rms, 0.05, 0.005);
  EXPECT_NEAR(figures.relative_mse, 0.0025, 0.0005);
  EXPECT_LT(figures.bias_low, -0.04);
  EXPECT_GT(figures.bias_high, -0.04);
  EXPECT_LT(figures.bias_high - figures.bias_low, 0.02);
}

TEST(ConvergeError, OfTheReferenceItselfIsNothing) {
  RandomStream random(2, "converge-error", 0);
  const ReferenceTruth truth(make_layers(0, random), "test");
  const RunError run = truth.compare(truth.layers().indirect.mean);
  EXPECT_EQ(run.square, 0);
  EXPECT_EQ(run.bias, 0);
  EXPECT_EQ(run.flip, 0);
  EXPECT_EQ(run.share_over_one_step, 0);
}

TEST(ConvergeError, CountsPixelsThatAreShownOtherwise) {
  RandomStream random(3, "converge-error", 0);
  const ReferenceTruth truth(make_layers(0, random), "test");
  HdrImage picture = truth.layers().indirect.mean;
  for (std::size_t i = 0; i < picture.pixel_count(); i += 40) picture.pixel(i)[1] *= 0.5f;
  const RunError run = truth.compare(picture);
  EXPECT_NEAR(run.share_over_one_step, 1.0 / 20, 1e-12);
  EXPECT_GT(run.flip, 0);
  EXPECT_NEAR(run.bias, -0.5 / 20 / 3, 1e-6);
}

// The interval of a mean holds the truth in 95 of 100 studies: 400 studies of 4 runs, level 1 %.
TEST(ConvergeError, HasAnIntervalThatHoldsTheBias) {
  RandomStream random(4, "converge-error", 0);
  int held = 0;
  for (int study = 0; study < 400; ++study) {
    const double reference = 0.01 * draw_normal(random);
    std::vector<RunError> runs(4);
    for (RunError& run : runs) run.bias = 0.1 + 0.02 * draw_normal(random) - reference;
    const ErrorFigures figures = summarise_runs(runs, 0.01);
    held += figures.bias_low <= 0.1 && 0.1 <= figures.bias_high;
  }
  EXPECT_GT(held, 400 * 0.95 - 2.58 * std::sqrt(400 * 0.95 * 0.05));
}

// Twelve pixels, whose channels go together, known by the mean of kBatches batches.
TruthLayers make_small_layers(double noise, RandomStream& random) {
  TruthLayers layers;
  const HdrImage black(4, 3);
  layers.background = layers.direct = black;
  layers.coverage = HdrImage(4, 3, 1);
  layers.indirect = {black, black};
  for (std::size_t i = 0; i < black.pixel_count(); ++i) {
    layers.coverage.values[i] = 1;
    double sum = 0, squares = 0;
    for (int batch = 0; batch < kBatches; ++batch) {
      const double value = 1 + std::sqrt(kBatches) * noise * draw_normal(random);
      sum += value;
      squares += value * value;
    }
    const double mean = sum / kBatches;
    for (std::size_t c = 0; c < 3; ++c) {
      layers.indirect.mean.pixel(i)[c] = static_cast<float>(mean);
      layers.indirect.standard_error.pixel(i)[c] =
          static_cast<float>(std::sqrt((squares / kBatches - mean * mean) / (kBatches - 1)));
    }
  }
  layers.tone = make_tone_curve(layers.indirect.mean, layers.coverage, ToneMapping{});
  return layers;
}

// Few pixels know the mean square badly, and all seeds by the same reference: 400 references of a noise of 27
// % beside pictures that are wrong by 4.3 or 60 % everywhere. Two standard errors of squares hold the truth
// in 95 of 100 at most, as squares are skewed: 88 are asked for.
TEST(ConvergeError, OfFewPixelsIsNotTakenForMoreThanIsKnown) {
  for (const double wrong : {0.043, 0.6}) {
    RandomStream random(6, "converge-error", 0);
    int held = 0, resolved = 0;
    for (int study = 0; study < 400; ++study) {
      const ReferenceTruth truth(make_small_layers(0.27, random), "test");
      HdrImage picture(4, 3);
      for (float& value : picture.values) value = static_cast<float>(1 + wrong);
      const RunError run = truth.compare(picture);
      const ErrorFigures figures = summarise_runs({run, run}, truth.error_of_mean());
      Convergence made;
      made.reference_square_error = truth.error_of_square();
      made.reference_rms = truth.rms_of_error();
      ConvergencePoint point;
      point.error = figures;
      // The picture's error in units of what is taken for the mean radiance.
      const double known = wrong / truth.mean(), rms = figures.relative_rms;
      resolved += is_resolved(made, point);
      held += is_resolved(made, point)
                  ? std::abs(rms * rms - known * known) <= 2 * 2 * rms * figures.relative_rms_error
                  : known <= find_least_error(made);
    }
    EXPECT_GT(held, 400 * 0.88) << wrong;
    if (wrong < 0.1) {
      EXPECT_LT(resolved, 400 * 0.12);
    } else {
      EXPECT_GT(resolved, 400 * 0.9);
    }
  }
}

ConvergeParams make_params() {
  ConvergeParams params;
  params.source = "test";
  params.condition = parse_condition("G0-grey-ind-1k-C9-v0", "test");
  params.width = 24;
  params.height = 18;
  params.seeds = 4;
  params.reference_paths = 4096;
  params.asked_s = {1000, 1e-9};
  params.ladders = {{30, 100, 300}, {3000, 10000}, {0.03, 0.0075}, {0, 4, 9}, 4};
  return params;
}

const ConvergencePoint& find_point(const Convergence& made, const std::string& series,
                                   const std::string& setting) {
  for (const ConvergencePoint& point : made.points) {
    if (point.series == series && point.setting == setting) return point;
  }
  throw std::runtime_error(series + " at " + setting);
}

class Converge : public testing::Test {
 protected:
  static const Convergence& made() {
    static const Convergence made = measure_convergence(test::make_metal_wall_scene(), make_params());
    return made;
  }
};

// Where light is smooth the lattice does better than the root.
TEST_F(Converge, FallsWithTheRootOfThePathsAtLeast) {
  const auto slope = [&] {
    const double first = find_point(made(), "path tracing", "16 paths a pixel").error.relative_rms,
                 last = find_point(made(), "path tracing", "1024 paths a pixel").error.relative_rms;
    return std::log(last / first) / std::log(64.0);
  }();
  EXPECT_LT(slope, -0.45);
  EXPECT_GT(slope, -1.5);
}

TEST_F(Converge, HasTheUnbiasedMethodsTruthInTheirIntervals) {
  int outside = 0, all = 0;
  for (const ConvergencePoint& point : made().points) {
    if (point.series != "path tracing" && point.series.find("compensated") == std::string::npos) continue;
    ++all;
    outside += point.error.bias_low > 0 || point.error.bias_high < 0;
  }
  EXPECT_GE(all, 8);
  EXPECT_LE(outside, 2) << "of " << all << " at level 5 %";
}

TEST_F(Converge, TellsWhatEachCauseDoes) {
  const auto part = [&](const std::string& name) {
    for (const ErrorPart& one : made().parts) {
      if (one.name == name) return one;
    }
    throw std::runtime_error(name);
  };
  // All the ball's light but a tenth part comes by gloss that Lambertian VPLs do not send on.
  EXPECT_LT(part("emission model").bias, -0.5);
  EXPECT_LT(part("clamping").bias, 0);
  EXPECT_EQ(part("lightcuts").relative_rms, 0) << "a plain sum";
  EXPECT_GT(part("VPL sampling").relative_rms, 0);
  EXPECT_NEAR(part("these together").relative_rms, part("the picture").relative_rms,
              0.1 * part("the picture").relative_rms);
  EXPECT_NEAR(part("these together").bias, part("the picture").bias,
              4 * std::hypot(part("these together").bias_error, part("the picture").bias_error));
  EXPECT_NEAR(part("VPL sampling").bias, 0, 4 * part("VPL sampling").bias_error);
}

TEST_F(Converge, AdvisesTheNearestThatIsFastEnough) {
  ASSERT_EQ(made().advice.size(), 2u);
  ASSERT_TRUE(made().advice[0].point);
  const double rms = made().points[*made().advice[0].point].error.relative_rms;
  for (const ConvergencePoint& point : made().points) EXPECT_GE(point.error.relative_rms, rms);
  EXPECT_FALSE(made().advice[1].point);
}

TEST_F(Converge, IsOneRowASettingInTheTable) {
  const std::string csv = format_convergence_csv(made());
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), static_cast<std::ptrdiff_t>(made().points.size() + 1));
  std::istringstream lines(csv);
  std::string header, first;
  std::getline(lines, header);
  std::getline(lines, first);
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(first.begin(), first.end(), ','));
  EXPECT_EQ(first.find("path tracing,16 paths a pixel,,,,16,,"), 0u) << first;
  EXPECT_NE(csv.find("\"C4, compensated\""), std::string::npos);
}

TEST_F(Converge, IsDrawnWithAName) {
  const std::string commands = format_convergence_plot(made(), PlotFormat::kSvg, "a'b.svg");
  EXPECT_NE(commands.find("set output 'a''b.svg'"), std::string::npos);
  for (const std::string& series : list_series(made()))
    EXPECT_NE(commands.find("title '" + series), std::string::npos) << series;
}

TEST_F(Converge, WritesCountsAsWholeNumbers) {
  Convergence some;
  some.points.resize(1);
  some.points[0].vpls = 5000000;
  some.points[0].paths_a_pixel = 1048576;
  EXPECT_NE(format_convergence_csv(some).find(",5000000,,,1048576,"), std::string::npos)
      << format_convergence_csv(some);
}

TEST_F(Converge, OfErrorsBelowTheNoiseIsNotDrawnAndSaysSo) {
  Convergence lost = made();
  lost.reference_square_error = 0.5e18 / 9;
  EXPECT_TRUE(can_be_drawn(made()));
  EXPECT_FALSE(can_be_drawn(lost));
  const std::string page = format_convergence_page(lost, "");
  EXPECT_EQ(page.find("!["), std::string::npos);
  EXPECT_NE(page.find("| under 33333333333 % |"), std::string::npos) << page;
}

TEST_F(Converge, IsDrawnByGnuplot) {
  const test::Folder folder;
  check_gnuplot();
  draw_convergence(made(), PlotFormat::kPng, folder / "it's.png");
  draw_convergence(made(), PlotFormat::kSvg, folder / "plot.svg");
  EXPECT_EQ(load_text(folder / "it's.png").substr(1, 3), "PNG");
  EXPECT_NE(load_text(folder / "plot.svg").find("path tracing, slope"), std::string::npos);
}

TEST(ConvergeError, NeedsAnObjectThatIsSeenAndLit) {
  RandomStream random(5, "converge-error", 0);
  TruthLayers unseen = make_layers(0, random), black = make_layers(0, random);
  unseen.coverage = HdrImage(40, 30, 1);
  black.indirect.mean = HdrImage(40, 30);
  EXPECT_THROW(ReferenceTruth(std::move(unseen), "G0"), InputError);
  EXPECT_THROW(ReferenceTruth(std::move(black), "G0"), InputError);
}

// With the same seeds figures are the same; times are not. Of every method a little.
TEST_F(Converge, RepeatsItself) {
  ConvergeParams params = make_params();
  params.seeds = 2;
  params.reference_paths = 256;
  params.ladders = {{30, 100}, {3000}, {0.03}, {0, 4}, 4};
  const Convergence once = measure_convergence(test::make_metal_wall_scene(), params),
                    again = measure_convergence(test::make_metal_wall_scene(), params);
  EXPECT_EQ(list_series(once), list_series(made()));
  ASSERT_EQ(again.points.size(), once.points.size());
  for (std::size_t i = 0; i < again.points.size(); ++i)
    EXPECT_EQ(again.points[i].error, once.points[i].error) << again.points[i].setting;
}

// More VPLs than there is memory for lose no setting but their own.
TEST(ConvergeFailure, LeavesOutWhatCannotBeMeasured) {
  ConvergeParams params = make_params();
  params.seeds = 2;
  params.reference_paths = 64;
  params.budget_s = 1e12;
  params.ladders = {{30}, {3000, 100'000'000'000}, {0.03}, {0, 9}, 1};
  const Convergence made = measure_convergence(test::make_metal_wall_scene(), params);
  EXPECT_NO_THROW(find_point(made, "lightcuts C0", "3k VPLs"));
  EXPECT_NO_THROW(find_point(made, "path tracing", "16 paths a pixel"));
  EXPECT_FALSE(made.parts.empty());
  ASSERT_EQ(made.left_out.size(), 2u);
  EXPECT_EQ(made.left_out[0].find("lightcuts C0 at 100000M VPLs: "), 0u) << made.left_out[0];
  EXPECT_NE(format_convergence_page(made, "").find("\n\nLeft out:\n\n- lightcuts C0 at"), std::string::npos);
}

// Nothing that is foreseen to take longer than the budget is begun; the first setting of a curve is not
// foreseen.
TEST(ConvergeBudget, EndsALadder) {
  ConvergeParams params = make_params();
  params.seeds = 2;
  params.reference_paths = 64;
  params.budget_s = 1e-6;
  const Convergence made = measure_convergence(test::make_metal_wall_scene(), params);
  for (const std::string& series : list_series(made))
    EXPECT_EQ(std::count_if(made.points.begin(), made.points.end(),
                            [&](const ConvergencePoint& point) { return point.series == series; }),
              1)
        << series;
}

}  // namespace
}  // namespace equilux
