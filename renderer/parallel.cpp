// The one file that knows oneTBB.
#include "renderer/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <optional>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>
#include <thread>

#include "base/work_control.h"
#include "renderer/world.h"

namespace equilux {

#ifdef __SANITIZE_THREAD__
// The thread sanitizer cannot see how a library that was built without it hands work from thread to thread.
void for_each_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  std::exception_ptr failure;
  WorkControl* const control = current_control();
  const auto work = [&] {
    flush_denormals();
    try {
      for (std::size_t i = next++; i < count; i = next++) {
        if (control) control->check();
        body(i);
      }
    } catch (...) {
      const std::lock_guard lock(mutex);
      failure = std::current_exception();
    }
  };
  std::vector<std::thread> threads;
  for (int i = 1; i < count_threads(); ++i) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
}
void sort_parallel(LargeArray<KeyedIndex>& values) { std::sort(values.begin(), values.end()); }
#else
void for_each_parallel(std::size_t count, const std::function<void(std::size_t)>& body) {
  WorkControl* const control = current_control();
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, count, 1),
      [&](const tbb::blocked_range<std::size_t>& range) {
        flush_denormals();
        for (std::size_t i = range.begin(); i != range.end(); ++i) {
          if (control) control->check();
          body(i);
        }
      },
      tbb::simple_partitioner());
}
void sort_parallel(LargeArray<KeyedIndex>& values) { tbb::parallel_sort(values.begin(), values.end()); }
#endif

int count_threads() {
  return static_cast<int>(std::min<std::size_t>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism), 4096));
}

int fit_threads(std::uint64_t bytes, std::optional<std::uint64_t> there) {
  const auto most = static_cast<std::uint64_t>(count_threads());
  if (!there || bytes == 0) return static_cast<int>(most);
  return static_cast<int>(std::clamp<std::uint64_t>(*there / bytes, 1, most));
}

struct ThreadLimit::Impl {
  std::optional<tbb::global_control> control;
};

ThreadLimit::ThreadLimit(int threads) : impl_(std::make_unique<Impl>()) {
  if (threads > 0) {
    impl_->control.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  }
}

ThreadLimit::~ThreadLimit() = default;

}  // namespace equilux
