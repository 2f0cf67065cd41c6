// A program that a test starts, watches and ends.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace equilux {

inline constexpr std::chrono::seconds kTestPatience{30};

/// Looks every few milliseconds until `condition` holds; false after kTestPatience.
bool wait_until(const std::function<bool()>& condition);

/// Killed, if it still runs, at the end of its life. Full disks reach it as errors, not as a signal.
class ChildProcess {
 public:
  /// `arguments` begin with the program. `environment` is added to the test's own. Where `report` is given
  /// the child's descriptor 3 is a pipe, and its first line is put there.
  explicit ChildProcess(const std::vector<std::string>& arguments,
                        const std::map<std::string, std::string>& environment = {},
                        std::string* report = nullptr);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  void send_signal(int signal) const;
  /// Lets no file of the child grow beyond this size from now on: a full disk.
  void limit_file_size(std::size_t bytes) const;
  bool is_running();
  /// Processor time that it has used, all threads. units: s
  double read_cpu_seconds() const;
  /// Memory that is its own and in use now.
  std::size_t read_memory_bytes() const;
  /// Exit code, 128 + signal, or nothing if it does not end in time.
  std::optional<int> wait();
  /// What it has written to standard output and standard error.
  std::string read_output();

 private:
  pid_t pid_ = -1;
  int output_ = -1;
  std::string text_;
  std::optional<int> code_;
};

}  // namespace equilux
