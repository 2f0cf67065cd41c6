// A clock before, at and behind what a log has recorded.
#include "experiment/clock_lag.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class ClockLagTest : public testing::Test {
 protected:
  // A session begun at noon, with an event at five past.
  void add_session() {
    const std::int64_t id = log_.append_session(make_fake_session(1), make_fake_trials(4));
    log_.append_event(id, "pause", 1);
    RawDatabase(path_).query("UPDATE session SET started_utc = '2026-06-01T12:00:00.000Z'");
    RawDatabase(path_).query("UPDATE event SET recorded_utc = '2026-06-01T12:05:00.000Z'");
  }

  TempFolder folder_;
  std::filesystem::path path_ = folder_ / "responses.sqlite";
  TrialLog log_{path_, true};
};

TEST_F(ClockLagTest, ThereIsNoneWithoutASessionAndAfterTheLastEvent) {
  EXPECT_FALSE(find_clock_lag(log_, "1990-01-01T00:00:00.000Z"));
  add_session();
  EXPECT_FALSE(find_clock_lag(log_, "2026-06-01T12:05:00.000Z"));
  EXPECT_FALSE(find_clock_lag(log_, "2026-06-01T12:04:10.000Z")) << "a time server's correction";
  EXPECT_FALSE(find_clock_lag(log_, "2027-06-01T12:05:00.000Z"));
}

TEST_F(ClockLagTest, IsCountedFromTheLatestOfStartsAndEvents) {
  add_session();
  const auto lag = find_clock_lag(log_, "2026-06-01T11:35:00.000Z");
  ASSERT_TRUE(lag);
  EXPECT_DOUBLE_EQ(lag->hours, 0.5);
  EXPECT_THAT(describe_clock_lag(*lag),
              AllOf(HasSubstr("clock says 2026-06-01T11:35:00.000Z"),
                    HasSubstr("of 2026-06-01T12:05:00.000Z"), HasSubstr("30 minutes later")));
  RawDatabase(path_).query("UPDATE session SET started_utc = '2026-06-03T11:35:00.000Z'");
  const auto longer = find_clock_lag(log_, "2026-06-01T11:35:00.000Z");
  ASSERT_TRUE(longer);
  EXPECT_THAT(describe_clock_lag(*longer), HasSubstr("48.0 hours later"));
}

TEST_F(ClockLagTest, IsOfTheSystemsClockWhereNoOtherIsGiven) {
  add_session();
  RawDatabase(path_).query("UPDATE session SET started_utc = '9999-06-03T11:35:00.000Z'");
  EXPECT_TRUE(find_clock_lag(log_));
}

}  // namespace
}  // namespace equilux
