// Convergence files come back as they were, and what is said of them follows from the points.
#include "stimuli/convergence.h"

#include <cmath>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

ConvergencePoint make_point(const char* series, double seconds, double rms) {
  ConvergencePoint point;
  point.series = series;
  point.setting = "one";
  point.wall_s = {{"shading", seconds * 0.75}, {"VPL tracing", seconds * 0.25}};
  point.cpu_s = {{"shading", 2 * seconds}};
  point.error.relative_rms = rms;
  point.error.relative_rms_error = rms / 5;
  point.error.bias = -rms / 3;
  point.error.flip = 0.25;
  return point;
}

Convergence make_convergence() {
  Convergence made;
  made.source = "cafe";
  made.condition = "G0-MS-ind-1k-C4-v0";
  made.width = made.height = made.positions = made.threads = 2;
  made.seeds = 3;
  made.seed = 7;
  made.isa = "v3";
  made.host = "desk";
  made.reference = "path tracing";
  made.reference_mean = 0.5;
  made.reference_rms = 0.01;
  made.reference_square_error = 5e-6;
  made.object_pixels = 3;
  made.points = {make_point("b", 4, .1), make_point("a", 1, .2), make_point("b", 2, .3),
                 make_point("b", 8, 0), make_point("a", 9, .05)};
  made.points[1].vpls = 1000;
  made.points[1].clamp_level = 0;
  made.points[1].error_ratio = 0.0075;
  made.slopes = {{"a", -0.5}};
  made.parts = {{"clamping", "paths", .1, -.02, .001}};
  made.advice = {{5, 0}, {.5, {}}};
  made.left_out = {"b at two: no memory"};
  return made;
}

TEST(ConvergenceFile, ComesBackAsItWas) {
  const TempFolder folder;
  const auto path = folder.path() / "x.json";
  save_convergence(make_convergence(), path);
  EXPECT_EQ(load_convergence(path), make_convergence());
}

// Of which an int would keep the lower half.
TEST(ConvergenceFile, WithNumbersBeyondAnIntIsRefused) {
  const TempFolder folder;
  const auto path = folder.path() / "x.json";
  for (const char* member : {"width", "height", "positions", "seeds", "threads"}) {
    save_convergence(make_convergence(), path);
    Json json = parse_json(load_text(path), "x");
    json.set(member, std::int64_t{4294967298});
    save_text(path, format_json(json));
    EXPECT_THROW(load_convergence(path), InputError) << member;
  }
}

TEST(ConvergenceFile, WithAdviceOfNoPointIsRefused) {
  const TempFolder folder;
  const auto path = folder.path() / "x.json";
  Convergence made = make_convergence();
  made.advice[0].point = 5;
  save_convergence(made, path);
  try {
    load_convergence(path);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("/advice/0/point: expected one of 5 points, got 5"),
              std::string::npos)
        << error.what();
  }
}

TEST(Convergence, ListsSeriesInTheirOrderAndTheSettingsThatNoneBeats) {
  const Convergence made = make_convergence();
  EXPECT_EQ(list_series(made), (std::vector<std::string>{"b", "a"}));
  EXPECT_EQ(find_slope(made, "a"), -0.5);
  EXPECT_FALSE(find_slope(made, "b"));
  const auto frontier = find_frontier(made);
  ASSERT_EQ(frontier.size(), 3u);
  EXPECT_EQ(frontier[0], &made.points[1]);
  EXPECT_EQ(frontier[1], &made.points[0]);
  EXPECT_EQ(frontier[2], &made.points[3]) << "lost in the noise, and fastest of those";
}

TEST(Convergence, CountsErrorsBelowTheReferencesNoiseAsEqual) {
  Convergence made = make_convergence();
  made.reference_square_error = 0.5 * 0.125 * 0.125;
  EXPECT_EQ(find_least_error(made), 0.125);
  EXPECT_TRUE(is_resolved(made, made.points[1]));
  EXPECT_FALSE(is_resolved(made, made.points[3]));
  EXPECT_FALSE(is_resolved(made, made.points[4]));
  EXPECT_EQ(format_error(made, made.points[4]), "under 12 %");
  EXPECT_EQ(format_error(made, make_point("a", 1, 2.5)), "250 %");
  const auto frontier = find_frontier(made);
  ASSERT_EQ(frontier.size(), 2u) << "of the equal ones the fastest";
  EXPECT_EQ(frontier[1], &made.points[0]);
}

TEST(Convergence, OfLightThatIsKnownExactlyHasNoErrorNotLessThanNone) {
  Convergence made = make_convergence();
  made.reference_rms = made.reference_square_error = 0;
  EXPECT_EQ(format_error(made, made.points[3]), "0 %");
  EXPECT_EQ(format_error_interval(made, made.points[3]), "0 %");
  EXPECT_EQ(format_error_interval(made, made.points[0]), "10.00 ± 2.00 %");
}

TEST(ConvergenceFile, WithoutTheErrorOfTheSquareHasThatOfEqualPixels) {
  const TempFolder folder;
  const auto path = folder.path() / "x.json";
  save_convergence(make_convergence(), path);
  std::string text = load_text(path);
  const std::size_t begin = text.rfind(',', text.find("\"square_error\""));
  text.erase(begin, text.find('}', begin) - begin);
  save_text(path, text);
  EXPECT_NEAR(load_convergence(path).reference_square_error, 1.5 * 1e-4 / std::sqrt(3), 1e-12);
}

TEST(Convergence, AdvisesInSentences) {
  EXPECT_EQ(format_advice(make_convergence()),
            "Within 5.0 s, the nearest to the truth is b at one: 10.00 ± 2.00 % rms, in 4.0 s. No setting "
            "that was measured takes under 0.5 s.");
  Convergence noisy = make_convergence();
  noisy.advice.clear();
  noisy.reference_rms = 0.27;
  EXPECT_EQ(format_advice(noisy),
            "The reference is noisy, by 27 % rms: more paths for it would tell methods apart.");
}

}  // namespace
}  // namespace equilux
