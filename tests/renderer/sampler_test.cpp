// The lattice with a random shift: uniform path by path, even all together.
#include "renderer/sampler.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/statistics.h"

namespace equilux {
namespace {

std::vector<float> take(PathSampler& sampler, int count) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i) values.push_back(sampler.next());
  return values;
}

TEST(PathSampler, PathsByIndexAreThoseOneAfterAnother) {
  RandomStream stream(1, "sampler", 0), again(1, "sampler", 0);
  const LatticePoint shift = draw_shift(again);
  PathSampler one_by_one(stream);
  for (std::uint64_t path = 0; path < 1000; ++path) {
    one_by_one.next_path();
    PathSampler at_once(shift, path, again);
    EXPECT_EQ(take(one_by_one, kLatticeDimensions), take(at_once, kLatticeDimensions));
  }
}

// One path's numbers over 200,000 shifts, the eighth path's and one far on: pairs of neighbouring dimensions,
// the last of the lattice's with the first of the stream's among them, in 16 x 16 bins. 18 tests at level 1 %
// over all.
TEST(PathSampler, APathByItselfIsUniform) {
  constexpr std::size_t kPairs = kLatticeDimensions;
  for (std::uint64_t path : {std::uint64_t{8}, std::uint64_t{10000000}}) {
    std::vector<std::vector<double>> observed(kPairs, std::vector<double>(256));
    for (std::uint64_t seed = 0; seed < 200000; ++seed) {
      RandomStream stream(seed, "uniform", 0);
      const LatticePoint shift = draw_shift(stream);
      PathSampler sampler(shift, path, stream);
      const auto values = take(sampler, kLatticeDimensions + 1);
      for (std::size_t i = 0; i < kPairs; ++i)
        ++observed[i][static_cast<std::size_t>(values[i] * 16) * 16 +
                      static_cast<std::size_t>(values[i + 1] * 16)];
    }
    for (const auto& counts : observed)
      EXPECT_GT(test::test_chi_squared(counts, std::vector<double>(256, 200000.0 / 256)).p, .01 / 18);
  }
}

// Standard error of the mean of `f` by 1,000 paths, over 200 shifts.
double find_spread(bool low_discrepancy, const auto& f) {
  std::vector<double> means;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    PathSampler sampler(RandomStream(seed, "spread", 0), low_discrepancy);
    double sum = 0;
    for (int path = 0; path < 1000; ++path) {
      sampler.next_path();
      sum += f(sampler);
    }
    means.push_back(sum / 1000);
  }
  return test::mean_of(means).standard_error;
}

TEST(PathSampler, ManyPathsTogetherAreEven) {
  const auto product = [](PathSampler& sampler) {
    double value = 1;
    for (int i = 0; i < 3; ++i) value *= sampler.next();
    return value;
  };
  EXPECT_LT(find_spread(true, product), find_spread(false, product) / 5);
}

// Whatever a path takes beyond the lattice, the next one's numbers are the same.
TEST(PathSampler, GivesAPathItsNumbersWhateverTheOneBeforeTook) {
  PathSampler brief{RandomStream(1, "sampler", 0)}, long_one{RandomStream(1, "sampler", 0)};
  for (int path = 0; path < 20; ++path) {
    brief.next_path();
    long_one.next_path();
    for (int draw = 0; draw < 12; ++draw) ASSERT_EQ(brief.next(), long_one.next()) << path << " " << draw;
    for (int draw = 0; draw < 100 * path; ++draw) long_one.next();
  }
}

}  // namespace
}  // namespace equilux
