// Pausing, going on and cancelling a job from another thread, and hearing of it.
#include "base/work_control.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "base/progress.h"

namespace equilux {
namespace {

using namespace std::chrono_literals;

// Threads that work piece by piece until they are cancelled.
class Workers {
 public:
  explicit Workers(WorkControl& control) {
    for (int i = 0; i < 3; ++i) {
      threads_.emplace_back([&] {
        try {
          for (;; ++pieces_) control.check();
        } catch (const WorkCancelled&) {
          ++cancelled_;
        }
      });
    }
  }
  void join() {
    for (std::jthread& thread : threads_) thread.join();
  }
  // Whether any of them does a piece within so long.
  bool works_within(std::chrono::milliseconds time) const {
    const long before = pieces_;
    for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
      if (pieces_ > before + 10) return true;
      std::this_thread::sleep_for(1ms);
    }
    return false;
  }
  int cancelled() const { return cancelled_; }

 private:
  std::atomic<long> pieces_ = 0;
  std::atomic<int> cancelled_ = 0;
  std::vector<std::jthread> threads_;
};

TEST(WorkControl, HoldsEveryThreadWhileItIsPausedAndEndsEachOnceItIsCancelled) {
  WorkControl control;
  Workers workers(control);
  EXPECT_TRUE(workers.works_within(5s));
  control.pause();
  std::this_thread::sleep_for(50ms);  // pieces that were begun
  EXPECT_FALSE(workers.works_within(200ms));
  control.resume();
  EXPECT_TRUE(workers.works_within(5s));
  control.cancel();
  workers.join();
  EXPECT_EQ(workers.cancelled(), 3);
}

TEST(WorkControl, CancelsAJobThatIsPausedAndKeepsItCancelled) {
  WorkControl control;
  control.pause();
  Workers workers(control);
  control.cancel();
  workers.join();
  EXPECT_EQ(workers.cancelled(), 3);
  control.resume();
  EXPECT_THROW(control.check(), WorkCancelled);
}

TEST(WorkControl, HearsOfProgressInPlaceOfStandardError) {
  WorkControl control;
  testing::internal::CaptureStderr();
  {
    const ControlledWork work(control);
    Progress progress("rendering", 4);
    progress.tell("backgrounds");
    progress.advance(1);
    EXPECT_THAT(control.line(), testing::MatchesRegex("rendering:  25 %, .* left; backgrounds"));
    std::this_thread::sleep_for(300ms);
    progress.tell("cuts");
    progress.advance(1);
    EXPECT_THAT(control.line(), testing::MatchesRegex("rendering:  50 %, .* left; cuts"));
    control.cancel();
    EXPECT_THROW(progress.advance(1), WorkCancelled);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_THAT(control.line(), testing::HasSubstr("50 %"));
}

// What stands before "left" in a line of progress. units: s
double seconds_left(const std::string& line) {
  std::smatch found;
  EXPECT_TRUE(std::regex_search(line, found, std::regex(R"((\d+\.\d) s left)"))) << line;
  return found.empty() ? NAN : std::stod(found[1]);
}

TEST(WorkControl, DoesNotTakeAPauseForWork) {
  WorkControl control;
  const auto start = std::chrono::steady_clock::now();
  const ControlledWork work(control);
  Progress progress("rendering", 2);
  control.pause();
  control.pause();  // once more is the same pause
  std::this_thread::sleep_for(500ms);
  EXPECT_GE(control.paused_seconds(), .5);
  control.resume();
  const double paused = control.paused_seconds();
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(control.paused_seconds(), paused);
  progress.advance(1);
  const double all = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LE(seconds_left(control.line()), all - .5 + .05);  // as long as the first half; told to a tenth
}

}  // namespace
}  // namespace equilux
