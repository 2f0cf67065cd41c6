// Where a program ends: exit codes, the message, and how a duration reads.
#include "base/program.h"

#include <csignal>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <new>
#include <thread>

#include "base/error.h"
#include "base/memory.h"
#include "base/progress.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using testing::MatchesRegex;

TEST(RunProgram, PassesTheExitCodeOn) {
  for (int code : {kExitOk, kExitError, kExitUsage, 7})
    EXPECT_EQ(run_program("p", [&] { return code; }), code);
  EXPECT_EQ(kExitOk, 0);
  EXPECT_EQ(kExitError, 1);
  EXPECT_EQ(kExitUsage, 2);
}

TEST(RunProgramDeathTest, SaysThatItWasInterrupted) {
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(run_program("p",
                            [&] {
                              std::raise(signal);
                              return 0;
                            }),
                testing::KilledBySignal(signal), "p: interrupted; what was finished until then is kept");
  }
}

TEST(RunProgramDeathTest, LeavesASignalIgnoredThatWas) {
  EXPECT_EXIT(
      {
        std::signal(SIGINT, SIG_IGN);
        std::exit(run_program("p", [] {
          std::raise(SIGINT);
          return 7;
        }));
      },
      testing::ExitedWithCode(7), "");
}

TEST(WithMemory, RunsWhatFitsAndNamesBothAmountsOfWhatDoesNot) {
  const auto there = find_available_memory();
  ASSERT_TRUE(there.has_value());
  EXPECT_GT(*there, 100u << 20);
  bool ran = false;
  with_memory("little", 1 << 20, [&] { ran = true; });
  EXPECT_TRUE(ran);
  EXPECT_THAT([] { with_memory("7 VPLs", std::uint64_t{1} << 50, [] { FAIL() << "it ran"; }); },
              testing::ThrowsMessage<InputError>(
                  MatchesRegex("7 VPLs: expected about 1048576.0 GiB of memory, got [0-9.]+ GiB")));
  EXPECT_THAT([] { with_memory("7 VPLs", 1, [] { throw std::bad_alloc(); }); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("an allocation failed with")));
}

TEST(RunProgram, TurnsAnExceptionIntoOneLineAndExitCodeOne) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_program("p", []() -> int { throw InputError("a.json", "/x", "1", "2"); }), 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "p: a.json: /x: expected 1, got 2\n");
  testing::internal::CaptureStderr();
  EXPECT_EQ(run_program("p", []() -> int { throw StoreError("full"); }), 1);
  EXPECT_EQ(run_program("p", []() -> int { throw std::bad_alloc(); }), 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "p: full\np: out of memory\n");
}

TEST(FormatUtcNow, IsIso8601WithMilliseconds) {
  EXPECT_THAT(format_utc_now(),
              MatchesRegex("[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}\\.[0-9]{3}Z"));
}

TEST(FormatSeconds, NeverShowsSixtyOfAnything) {
  const std::pair<double, const char*> cases[] = {
      {0, "0.0 s"},           {4.14, "4.1 s"},      {9.94, "9.9 s"},       {9.96, "10 s"},
      {59.4, "59 s"},         {59.6, "1 min 00 s"}, {200, "3 min 20 s"},   {3599.4, "59 min 59 s"},
      {3599.6, "1 h 00 min"}, {3720, "1 h 02 min"}, {86400, "24 h 00 min"}};
  for (const auto& [seconds, text] : cases) EXPECT_EQ(format_seconds(seconds), text) << seconds;
}

TEST(ProgressOfAShortJob, SaysNothing) {
  testing::internal::CaptureStderr();
  {
    Progress progress("job", 10);
    for (int i = 0; i < 10; ++i) progress.advance(1);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

// Half of the work in a little over two seconds; then the job ends there, by itself or by an error.
TEST(ProgressOfALongJob, SaysHowLongItTookAndNeverThatAWholeJobIsHalfDone) {
  testing::internal::CaptureStderr();
  const auto work = [](bool fails) {
    Progress progress("job", 10);
    std::this_thread::sleep_for(std::chrono::milliseconds(2050));
    progress.advance(5);
    if (fails) throw StoreError("full");
  };
  work(false);
  EXPECT_THROW(work(true), StoreError);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              MatchesRegex("job:  50 %, 2\\.[0-9] s left\njob: done in 2\\.[0-9] s\n"
                           "job:  50 %, 2\\.[0-9] s left\njob: stopped after 2\\.[0-9] s\n"));
}

}  // namespace
}  // namespace equilux
