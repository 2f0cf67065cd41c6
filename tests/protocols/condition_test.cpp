// Keys of conditions: what they look like, and what is refused as one; the clamp levels.
#include "protocols/condition.h"

#include <cmath>
#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const Column kColumn{{"G1", "MR", Illumination::kIndirect}, 100000};

TEST(Clamp, HasTheElevenLevelsOfTheStudy) {
  const double levels[] = {INFINITY, 316.2278, 100, 31.62278, 10, 3.162278, 1, .3162278, .1, .03162278, .01};
  for (int i = 1; i < kClampLevelCount; ++i) EXPECT_NEAR(clamp_per_m2(i) / levels[i], 1, 1e-6) << i;
  EXPECT_TRUE(std::isinf(clamp_per_m2(0)));
  EXPECT_EQ(std::size(levels), static_cast<std::size_t>(kClampLevelCount));
  EXPECT_THROW(clamp_per_m2(-1), CheckFailure);
  EXPECT_THROW(clamp_per_m2(11), CheckFailure);
}

TEST(Keys, LookAsTheStudySays) {
  EXPECT_EQ(format_key(kColumn.object), "G1-MR-ind");
  EXPECT_EQ(format_key(kColumn), "G1-MR-ind-100k");
  EXPECT_EQ(format_key(Cell{kColumn, 4, false}), "G1-MR-ind-100k-C4");
  EXPECT_EQ(format_key(Cell{kColumn, 4, true}), "G1-MR-ind-100k-C4n");
  EXPECT_EQ(format_key(Condition{{kColumn, 4, false}, 0}), "G1-MR-ind-100k-C4-v0");
  EXPECT_EQ(format_key(Family{kColumn.object, 1}), "G1-MR-ind-ref-v1");
  EXPECT_EQ(family_of({{kColumn, 4, false}, 1}), (Family{kColumn.object, 1}));
}

TEST(VplCounts, AreWrittenInOneWayOnly) {
  const std::pair<std::int64_t, const char*> cases[] = {
      {1, "1"},         {999, "999"},       {1000, "1k"},    {1001, "1001"},    {10000, "10k"},
      {100000, "100k"}, {1500000, "1500k"}, {5000000, "5M"}, {25000000, "25M"}, {1000000000, "1000M"}};
  for (const auto& [count, text] : cases) {
    EXPECT_EQ(format_vpl_count(count), text);
    EXPECT_EQ(parse_vpl_count(text, "test"), count);
    EXPECT_TRUE(is_vpl_count(text)) << text;
  }
}

TEST(VplCounts, RefuseWhatIsNoCount) {
  for (const char* text : {"", "0", "0k", "k", "M", "1K", "1m", "-1k", "+1k", "1.5M", "1 k", "01k", "1kk",
                           "1001M", "99999999999999999999", "1e3", "0x10"}) {
    EXPECT_THROW(parse_vpl_count(text, "test"), InputError) << text;
    EXPECT_FALSE(is_vpl_count(text)) << text;
  }
}

TEST(ClampLevels, RefuseWhatIsNone) {
  for (const char* text : {"", "C", "C11", "C-1", "C01", "c4", "4", "C4n", "C4 ", " C4", "C4x", "Cn"})
    EXPECT_THROW(parse_clamp_level(text, "test"), InputError) << text;
  EXPECT_EQ(parse_clamp_level("C0", "test"), 0);
  EXPECT_EQ(parse_clamp_level("C10", "test"), 10);
}

TEST(ConditionKeys, RefuseEveryMalformedOne) {
  const char* malformed[] = {"",
                             "-",
                             "G1",
                             "G1-MR-ind-100k-C4",
                             "G1-MR-ind-0100k-C4-v0",
                             "G1-MR-ind-100k-C11-v0",
                             "G1-MR-ind-100k-C4-v2",
                             "G1-MR-ind-1000k-C4-v0",
                             "G1-MR-ind-1000-C4-v0",
                             "G1-MR-ind-100k-C4-v0-",
                             "G1-MR-ind-100k-C4-v0x",
                             "G1-MR-ind-100k-C4-v00",
                             "G1-MR-ind-100k-C4-v0\n",
                             "G1-MR-ind-100k-C4-v0 ",
                             " G1-MR-ind-100k-C4-v0",
                             "G1-MR-IND-100k-C4-v0",
                             "G1-MR-both-100k-C4-v0",
                             "G1--ind-100k-C4-v0",
                             "-MR-ind-100k-C4-v0",
                             "G1-MR--100k-C4-v0",
                             "G1-MR-ind--C4-v0",
                             "G1-MR-ind-100k--v0",
                             "G1-MR-ind-100k-C4-",
                             "1G-MR-ind-100k-C4-v0",
                             "G_1-MR-ind-100k-C4-v0",
                             "G1-M R-ind-100k-C4-v0",
                             "G1-MR-ind-100K-C4-v0",
                             "G1-MR-ind-0-C4-v0",
                             "G1-MR-ind-100k-C04-v0",
                             "G1-MR-ind-100k-C4nn-v0",
                             "G1-MR-ind-100k-Cn-v0",
                             "G1-MR-ind-100k-C-4-v0",
                             "G1-MR-ind-100k-C4-V0",
                             "G1-MR-ind-100k-C4-v-1",
                             "G1-MR-ind-ref-v0",
                             "G1-MR-ind-100k-C4-v0-v1",
                             "G1/MR/ind/100k/C4/v0",
                             "../G1-MR-ind-100k-C4-v0",
                             "G1-MR-ind-2000M-C4-v0",
                             "G\xc3\xa9-MR-ind-1k-C4-v0",
                             "A1234567890123456789012345678901X-MR-ind-1k-C4-v0"};
  for (const char* text : malformed) EXPECT_THROW(parse_condition(text, "test"), InputError) << text;
  EXPECT_NO_THROW(parse_condition("G1-MR-ind-100k-C4-v0", "test"));
}

TEST(FamilyKeys, RefuseEveryMalformedOne) {
  for (const char* text :
       {"", "G1-MR-ind-ref", "G1-MR-ind-ref-v2", "G1-MR-ind-REF-v0", "G1-MR-ind-v0", "G1-MR-ind-100k-C4-v0",
        "G1-MR-ind-ref-v0-", "G1-MR-ref-ind-v0", "G1-MR-ind-1k-v0"})
    EXPECT_THROW(parse_family(text, "test"), InputError) << text;
}

TEST(CellAndColumnKeys, RefuseOneAnother) {
  EXPECT_THROW(parse_column("G1-MR-ind-100k-C4", "test"), InputError);
  EXPECT_THROW(parse_column("G1-MR-ind", "test"), InputError);
  EXPECT_THROW(parse_cell("G1-MR-ind-100k", "test"), InputError);
  EXPECT_THROW(parse_cell("G1-MR-ind-100k-C4-v0", "test"), InputError);
}

TEST(KeyErrors, NameSourcePlaceFormAndText) {
  EXPECT_THAT(message_of<InputError>([] { parse_condition("G1-MR", "m.json", "/pictures/0/key"); }),
              AllOf(StartsWith("m.json: /pictures/0/key: "), HasSubstr("G1-MR-ind-100k-C4-v0"),
                    HasSubstr("\"G1-MR\"")));
  const std::string shown = message_of<InputError>([] { parse_column(std::string(100000, 'x'), "m.json"); });
  EXPECT_LT(shown.size(), 250u) << "a message does not repeat a megabyte";
}

TEST(Tokens, AreLettersAndDigitsThatBeginWithALetter) {
  for (const char* text : {"G0", "Bunny", "a", "Z9", "A1234567890123456789012345678901"})
    EXPECT_TRUE(is_token(text)) << text;
  for (const char* text : {"", "0G", "G-0", "G 0", "G.", "\xc3\xa9", "A12345678901234567890123456789012"})
    EXPECT_FALSE(is_token(text)) << text;
}

}  // namespace
}  // namespace equilux
