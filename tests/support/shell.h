// Other programs, run as a user would.
#pragma once

#include <cstdio>
#include <string>
#include <sys/wait.h>

#include "base/error.h"

namespace equilux::test {

struct CommandResult {
  int exit_code = -1;
  std::string text;  ///< both streams
};

inline CommandResult run_shell(const std::string& command) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  EQ_CHECK(pipe != nullptr);
  CommandResult result;
  char buffer[4096];
  while (std::fgets(buffer, sizeof buffer, pipe)) result.text += buffer;
  const int status = pclose(pipe);
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  return result;
}

}  // namespace equilux::test
