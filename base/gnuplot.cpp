// popen, and no death by a closed pipe.
#include "base/gnuplot.h"

#include <csignal>
#include <cstdio>
#include <sys/wait.h>

namespace equilux {
namespace {

// A program that ends early closes the pipe: that is an answer, not our death.
class IgnoredPipeSignal {
 public:
  IgnoredPipeSignal() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~IgnoredPipeSignal() { std::signal(SIGPIPE, before_); }
  IgnoredPipeSignal(const IgnoredPipeSignal&) = delete;
  IgnoredPipeSignal& operator=(const IgnoredPipeSignal&) = delete;

 private:
  void (*before_)(int);
};

}  // namespace

// The shell would say on standard error that there is none: whoever asks says it better.
int run_gnuplot(const std::string& commands) {
  const IgnoredPipeSignal ignored;
  FILE* pipe = popen("command -v gnuplot >/dev/null || exit 127; exec gnuplot", "w");
  if (!pipe) return -1;
  std::fwrite(commands.data(), 1, commands.size(), pipe);
  const int status = pclose(pipe);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace equilux
