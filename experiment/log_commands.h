// What an experimenter does with a log between and after sessions: status, export, withdraw, merge.
#pragma once

#include <memory>
#include <optional>

namespace CLI {
class App;
}

namespace equilux {

/// These subcommands of equilux-session.
class LogCommands {
 public:
  /// Adds them to the program's command line.
  explicit LogCommands(CLI::App& app);
  ~LogCommands();

  /// Runs the one that was asked for, and gives its exit code; empty if it was none of these. errors:
  /// InputError, StoreError
  std::optional<int> run() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace equilux
