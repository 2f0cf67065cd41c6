// Parallel loops. Results never depend on which thread does what.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace equilux {

/// Calls body(0) .. body(count - 1), each once, on all threads, with denormals flushed.
void for_each_parallel(std::size_t count, const std::function<void(std::size_t)>& body);

/// Threads that a loop may use now.
int count_threads();

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
