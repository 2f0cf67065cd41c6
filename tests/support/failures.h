// Ways to make things fail, and to look at how they failed.
#pragma once

#include <csignal>
#include <gmock/gmock.h>
#include <string>
#include <sys/resource.h>
#include <typeinfo>

namespace equilux {

/// The message of the Error that `act` throws. Another exception goes on to the test; none fails it and gives
/// "".
template <typename Error, typename Act>
std::string message_of(const Act& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing was thrown; expected " << typeid(Error).name();
  return {};
}

/// While it lives no file of this process can grow beyond `bytes`: a disk that is full at any place one
/// likes.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit wanted{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &wanted);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

}  // namespace equilux
