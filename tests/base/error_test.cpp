// What an error says, and that a check is on in every build.
#include "base/error.h"

#include <gtest/gtest.h>

#include "tests/support/failures.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(InputErrors, NamePathPlaceExpectedAndGot) {
  EXPECT_STREQ(InputError("a.json", "/seed", "a number", "\"x\"").what(),
               "a.json: /seed: expected a number, got \"x\"");
  EXPECT_STREQ(InputError("a.json", "", "a file", "a folder").what(),
               "a.json: expected a file, got a folder");
}

TEST(Checks, PrintConditionPlaceAndValuesInEveryBuild) {
  const int small = 3, large = 4;
  const auto fail = [&] { EQ_CHECK(small > large, small, large); };
  EXPECT_THAT(message_of<CheckFailure>(fail),
              AllOf(HasSubstr("small > large"), HasSubstr("(3, 4)"), HasSubstr("error_test.cpp")));
  EXPECT_NO_THROW(EQ_CHECK(small < large, small, large));
  EXPECT_THROW(EQ_CHECK(small == large), CheckFailure);
}

}  // namespace
}  // namespace equilux
