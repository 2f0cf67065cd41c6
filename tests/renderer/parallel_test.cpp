// Parallel loops: every index once, errors, and the control of the thread that runs them.
#include "renderer/parallel.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <stdexcept>
#include <thread>

#include "base/work_control.h"

namespace equilux {
namespace {

TEST(ParallelLoop, CallsItsBodyOnceForEachIndex) {
  std::vector<std::atomic<int>> calls(1000);
  for_each_parallel(calls.size(), [&](std::size_t i) { ++calls[i]; });
  EXPECT_TRUE(std::all_of(calls.begin(), calls.end(), [](const auto& count) { return count == 1; }));
}

TEST(ParallelLoop, ThrowsWhatItsBodyThrows) {
  EXPECT_THROW(for_each_parallel(100,
                                 [](std::size_t i) {
                                   if (i == 7) throw std::runtime_error("seven");
                                 }),
               std::runtime_error);
}

TEST(ParallelLoop, FitsAsManyThreadsAsThereIsMemoryFor) {
  const ThreadLimit limit(3);
  EXPECT_EQ(count_threads(), 3);
  EXPECT_EQ(fit_threads(100, 299), 2);
  EXPECT_EQ(fit_threads(100, 1000), 3);
  EXPECT_EQ(fit_threads(100, 99), 1) << "that one fits is asked elsewhere";
  EXPECT_EQ(fit_threads(100, {}), 3);
}

// Long enough that a thread which is kept waiting between two lines misses few of them.
void do_a_piece() { std::this_thread::sleep_for(std::chrono::microseconds(200)); }

TEST(ParallelLoop, IsEndedByTheControlOfItsThread) {
  WorkControl control;
  const ControlledWork work(control);
  std::atomic<int> calls = 0;
  EXPECT_THROW(for_each_parallel(20000,
                                 [&](std::size_t) {
                                   do_a_piece();
                                   if (++calls == 10) control.cancel();
                                 }),
               WorkCancelled);
  EXPECT_LT(calls, 10000);
  EXPECT_THROW(check_control(), WorkCancelled);
}

TEST(ParallelLoop, IsHeldByTheControlOfItsThreadAndGoesOn) {
  WorkControl control;
  std::atomic<int> calls = 0;
  std::jthread thread([&] {
    const ControlledWork work(control);
    for_each_parallel(5000, [&](std::size_t) {
      do_a_piece();
      if (++calls == 10) control.pause();
    });
  });
  while (calls < 10) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  const int held = calls;
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  EXPECT_EQ(calls, held);
  EXPECT_LT(held, 5000);
  control.resume();
  thread.join();
  EXPECT_EQ(calls, 5000);
}

TEST(ParallelLoop, OfAThreadThatNobodyWatchesIsUnderNoControl) {
  WorkControl control;
  control.cancel();
  { const ControlledWork work(control); }
  EXPECT_EQ(current_control(), nullptr);
  EXPECT_NO_THROW(for_each_parallel(10, [](std::size_t) {}));
}

}  // namespace
}  // namespace equilux
