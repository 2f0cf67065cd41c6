// Parallel loops. Results never depend on which thread does what.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "base/large_array.h"

namespace equilux {

/// Calls body(0) .. body(count - 1), each once, on all threads, with denormals flushed. errors: those of the
/// body; WorkCancelled where this thread's work is controlled
void for_each_parallel(std::size_t count, const std::function<void(std::size_t)>& body);

/// A sort key and what it stands for.
struct KeyedIndex {
  std::uint64_t key = 0;
  std::uint32_t index = 0;
  auto operator<=>(const KeyedIndex&) const = default;
};

/// By key, then by index: the same order on any number of threads.
void sort_parallel(LargeArray<KeyedIndex>& values);

/// Threads that a loop may use now.
int count_threads();

/// Of these threads those that fit at once, each taking `bytes` of what there is; one at least. `there` is
/// empty where the system does not say.
int fit_threads(std::uint64_t bytes, std::optional<std::uint64_t> there);

/// While it lives, loops use at most this many threads (0: as many as there are cores).
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace equilux
