// Philox against the known answers of Random123, and streams, draws and shuffles against chi-squared.
#include "base/random.h"

#include <gtest/gtest.h>
#include <map>
#include <set>

#include "base/below.h"
#include "base/error.h"
#include "base/random_run.h"

namespace equilux {
namespace {

using Block = std::array<std::uint32_t, 4>;

// Pearson's statistic of counts that should all be equal.
double chi_squared_of_equal(const std::vector<int>& counts) {
  double total = 0, sum = 0;
  for (int count : counts) total += count;
  const double expected = total / static_cast<double>(counts.size());
  for (int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

std::vector<std::uint32_t> draw(RandomStream stream, int count) {
  std::vector<std::uint32_t> values;
  for (int i = 0; i < count; ++i) values.push_back(stream.next_u32());
  return values;
}

// source: Random123 1.14, kat_vectors, philox4x32 10.
TEST(Philox, GivesTheKnownAnswersOfRandom123) {
  EXPECT_EQ(philox4x32({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  const std::uint32_t ones = 0xffffffff;
  EXPECT_EQ(philox4x32({ones, ones, ones, ones}, {ones, ones}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

// source: Fowler, Noll, Vo; the test vectors of draft-eastlake-fnv.
TEST(HashName, IsFnv1a) {
  EXPECT_EQ(hash_name(""), 0xcbf29ce484222325ULL);
  EXPECT_EQ(hash_name("a"), 0xaf63dc4c8601ec8cULL);
  EXPECT_EQ(hash_name("foobar"), 0x85944171f73967e8ULL);
}

TEST(RandomStreams, DoNotDependOnTheOrderInWhichTheyAreDrawn) {
  const auto alone = draw(RandomStream(5, "side", 3), 20);
  RandomStream first(5, "side", 2), second(5, "side", 3);
  for (std::uint32_t value : alone) {
    first.next_u64();
    EXPECT_EQ(second.next_u32(), value);
  }
  EXPECT_EQ(draw(RandomStream(make_stream_key(5, "side"), 3), 20), alone);
}

TEST(RandomStreams, DifferForEverySeedNameAndIndex) {
  std::set<std::vector<std::uint32_t>> streams;
  int count = 0;
  for (std::uint64_t seed : {0ULL, 1ULL, 2ULL, 1ULL << 32, 1ULL << 63, ~0ULL}) {
    for (const char* what : {"", "side", "view", "sidf", "order"}) {
      for (std::uint64_t index : {0ULL, 1ULL, 2ULL, 1ULL << 31, 1ULL << 32, ~0ULL}) {
        streams.insert(draw(RandomStream(seed, what, index), 4));
        ++count;
      }
    }
  }
  EXPECT_EQ(static_cast<int>(streams.size()), count);
}

TEST(RandomStreams, MakeBothHalvesOf64BitsAndFractionsBelowOne) {
  RandomStream narrow(9, "bits", 0), wide(9, "bits", 0);
  const std::uint64_t low = narrow.next_u32(), high = narrow.next_u32();
  EXPECT_EQ(wide.next_u64(), low | high << 32);
  RandomStream stream(9, "fractions", 0);
  for (int i = 0; i < 100000; ++i) {
    const float f = stream.next_float();
    const double d = stream.next_double();
    ASSERT_TRUE(f >= 0 && f < 1 && d >= 0 && d < 1) << f << ' ' << d;
  }
}

TEST(NextBelow, StaysBelowAndRefusesZero) {
  RandomStream stream(1, "below", 0);
  for (std::uint64_t count : {1ULL, 2ULL, 3ULL, 1ULL << 32, (1ULL << 63) + 1, ~0ULL}) {
    for (int i = 0; i < 200; ++i) ASSERT_LT(stream.next_below(count), count);
  }
  EXPECT_THROW(stream.next_below(0), CheckFailure);
}

// Seed 42, n = 140,000 draws of 7 values, level 0.1 %: 6 degrees of freedom, 22.46.
TEST(NextBelow, GivesEachOfSevenValuesEquallyOften) {
  RandomStream stream(42, "below", 0);
  std::vector<int> counts(7);
  for (int i = 0; i < 140000; ++i) ++counts[stream.next_below(7)];
  EXPECT_LT(chi_squared_of_equal(counts), 22.46);
}

// With a count of 3 x 2^62 the remainder alone would favour the first third by 2 to 1.
// Seed 43, n = 90,000 draws in thirds, level 0.1 %: 2 degrees of freedom, 13.82.
TEST(NextBelow, IsUnbiasedWhereARemainderWouldNotBe) {
  const std::uint64_t third = 1ULL << 62;
  RandomStream stream(43, "below", 0);
  std::vector<int> counts(3);
  for (int i = 0; i < 90000; ++i) ++counts[stream.next_below(3 * third) / third];
  EXPECT_LT(chi_squared_of_equal(counts), 13.82);

  std::vector<int> mutant(3);  // the kept mutant: a remainder without rejection
  for (int i = 0; i < 90000; ++i) ++mutant[stream.next_u64() % (3 * third) / third];
  EXPECT_GT(chi_squared_of_equal(mutant), 13.82);
}

TEST(Below, DrawsWhatNextBelowDraws) {
  for (std::uint64_t count : {1ULL, 2ULL, 3ULL, 1400ULL, 1ULL << 32, 3ULL << 62, (1ULL << 63) + 1, ~0ULL}) {
    RandomStream one(44, "below", count), other(44, "below", count);
    const Below below(count);
    for (int i = 0; i < 200; ++i) ASSERT_EQ(below(one), other.next_below(count)) << count;
  }
  EXPECT_THROW(Below(0), CheckFailure);
}

// Over several refills, in draws of both sizes, so that one of 64 bits falls between two refills.
TEST(RandomRun, DrawsWhatItsStreamDraws) {
  for (const std::uint64_t index : {0ULL, 1ULL, 0xffffffffULL, 1ULL << 32, ~0ULL}) {
    RandomRun run(~0ULL - index, "run", index);
    RandomStream stream(~0ULL - index, "run", index);
    for (int i = 0; i < 500; ++i) {
      ASSERT_EQ(run.next_u64(), stream.next_u64()) << index << ", " << i;
      if (i % 7 == 0) {
        ASSERT_EQ(run.next_u32(), stream.next_u32()) << index << ", " << i;
      }
      ASSERT_EQ(run.next_double(), stream.next_double()) << index << ", " << i;
    }
  }
}

TEST(Below, DrawsTheSameFromARun) {
  RandomRun run(44, "below", 3);
  RandomStream stream(44, "below", 3);
  const Below below(3ULL << 62);
  for (int i = 0; i < 200; ++i) ASSERT_EQ(below(run), below(stream)) << i;
}

TEST(Below, HasTheRemainderAtTheEndsOfEachMultiple) {
  for (std::uint64_t count :
       {1ULL, 2ULL, 3ULL, 7ULL, 641ULL, (1ULL << 32) - 1, 1ULL << 63, (1ULL << 63) + 1, ~0ULL - 1, ~0ULL}) {
    const Below below(count);
    for (const std::uint64_t multiple : {std::uint64_t{1}, UINT64_MAX / count / 2, UINT64_MAX / count}) {
      for (const std::uint64_t value :
           {multiple * count - 1, multiple * count, multiple * count + 1, UINT64_MAX})
        ASSERT_EQ(below.find_remainder(value), value % count) << value << " " << count;
    }
  }
}

// Seed 7, n = 48,000 shuffles of 4, level 0.1 %: 23 degrees of freedom, 49.73.
TEST(Shuffle, GivesAllOrdersOfFourEquallyOften) {
  std::map<std::vector<int>, int> orders, mutant_orders;
  RandomStream stream(7, "shuffle", 0);
  for (int i = 0; i < 48000; ++i) {
    std::vector<int> values{0, 1, 2, 3}, mutant = values;
    shuffle(values, stream);
    ++orders[values];
    for (std::size_t j = 0; j < 4; ++j) std::swap(mutant[j], mutant[stream.next_below(4)]);
    ++mutant_orders[mutant];
  }
  const auto statistic = [](const std::map<std::vector<int>, int>& found) {
    std::vector<int> counts(24 - found.size(), 0);
    for (const auto& [order, count] : found) counts.push_back(count);
    return chi_squared_of_equal(counts);
  };
  EXPECT_LT(statistic(orders), 49.73);
  EXPECT_GT(statistic(mutant_orders), 49.73);  // the kept mutant: partners drawn from all places
}

TEST(Shuffle, LeavesNoneAndOneAlone) {
  RandomStream stream(7, "shuffle", 0);
  std::vector<int> none, one{5};
  shuffle(none, stream);
  shuffle(one, stream);
  EXPECT_TRUE(none.empty());
  EXPECT_EQ(one, std::vector<int>{5});
}

}  // namespace
}  // namespace equilux
