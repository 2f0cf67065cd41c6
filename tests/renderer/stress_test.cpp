// Every stiff and extreme case holds, and the table says so.
#include "renderer/stress.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace equilux {
namespace {

void expect_to_hold(const std::vector<StressRow>& rows) {
  EXPECT_FALSE(rows.empty());
  for (const StressRow& row : rows) EXPECT_NE(row.outcome, StressOutcome::kFails) << format_stress({row});
}

TEST(Stress, OfMaterialsHolds) { expect_to_hold(stress_materials()); }
// Of five million a plain sum in float would miss by .3 and .6 per cent as they come and strongest first; the
// command takes 25 million.
TEST(Stress, OfVplsHolds) { expect_to_hold(stress_vpls(5)); }
TEST(Stress, OfLightcutsHolds) { expect_to_hold(stress_lightcuts()); }
TEST(Stress, OfScenesHolds) { expect_to_hold(stress_scenes()); }
TEST(Stress, OfPicturesHolds) { expect_to_hold(stress_pictures()); }

TEST(Stress, ARowThatFailsShowsInTheTable) {
  EXPECT_NE(format_stress({make_stress_row("a", "b", "c", "d", false)}).find("| a | b | c | d | FAILS |"),
            std::string::npos);
  EXPECT_NE(format_stress({make_stress_row("a", "b", "c", "d", true)}).find("holds"), std::string::npos);
}

TEST(Stress, AnErrorThatDoesNotComeFails) {
  EXPECT_EQ(expect_input_error("a", "b", [] {}).outcome, StressOutcome::kFails);
  EXPECT_EQ(expect_input_error("a", "b", [] { throw InputError("x"); }).outcome, StressOutcome::kHolds);
}

}  // namespace
}  // namespace equilux
