// fork, exec, and a pipe for its progress lines.
#include "experiment/app/background_render.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

#include "base/error.h"

namespace equilux {
namespace {

constexpr int kNiceness = 10;  // the window comes first

// The renderer stands beside this program.
std::filesystem::path find_program() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "equilux-render";
}

[[noreturn]] void become(const std::string& program, const std::string& study, const std::string& folder,
                         int output) {
  ::setpgid(0, 0);
  ::setpriority(PRIO_PROCESS, 0, kNiceness);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  ::execl(program.c_str(), program.c_str(), "set", study.c_str(), "--out", folder.c_str(),
          static_cast<char*>(nullptr));
  ::_exit(127);
}

}  // namespace

BackgroundRender::~BackgroundRender() {
  cancel();
  if (pid_ > 0) ::waitpid(pid_, nullptr, 0);
  if (output_ >= 0) ::close(output_);
}

void BackgroundRender::start(const std::filesystem::path& study_file, const std::filesystem::path& folder) {
  if (state_ == RenderState::kRunning || state_ == RenderState::kPaused) {
    if (is_cancelled_) wanted_.emplace(study_file, folder);
    return;
  }
  const std::string program = find_program(), study = study_file, root = folder;
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0)
    throw StoreError(fmt::format("cannot start {}: {}", program, std::strerror(errno)));
  pid_ = ::fork();
  if (pid_ == 0) become(program, study, root, ends[1]);
  if (pid_ > 0) ::setpgid(pid_, pid_);  // here too: it may be paused before it has got so far
  ::close(ends[1]);
  if (output_ >= 0) ::close(output_);
  output_ = ends[0];
  if (pid_ < 0) throw StoreError(fmt::format("cannot start {}: {}", program, std::strerror(errno)));
  partial_.clear();
  line_ = "starting";
  is_cancelled_ = false;
  state_ = RenderState::kRunning;
}

void BackgroundRender::pause() {
  if (state_ != RenderState::kRunning) return;
  ::kill(-pid_, SIGSTOP);
  state_ = RenderState::kPaused;
}

void BackgroundRender::resume() {
  if (state_ != RenderState::kPaused) return;
  ::kill(-pid_, SIGCONT);
  state_ = RenderState::kRunning;
}

void BackgroundRender::cancel() {
  if (state_ != RenderState::kRunning && state_ != RenderState::kPaused) return;
  is_cancelled_ = true;
  wanted_.reset();
  ::kill(-pid_, SIGTERM);
  ::kill(-pid_, SIGCONT);
}

void BackgroundRender::read_output() {
  char bytes[4096];
  for (ssize_t count; (count = ::read(output_, bytes, sizeof bytes)) > 0;) {
    for (ssize_t i = 0; i < count; ++i) {
      const char letter = bytes[i];
      if (letter != '\n' && letter != '\r') {
        partial_ += letter;
      } else if (!partial_.empty()) {
        line_ = std::exchange(partial_, {});
      }
    }
  }
}

RenderState BackgroundRender::poll() {
  if (pid_ <= 0) return state_;
  read_output();
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return state_;
  pid_ = -1;
  read_output();
  const bool is_done = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (WIFEXITED(status) && WEXITSTATUS(status) == 127) line_ = "equilux-render is not beside this program";
  state_ = is_done ? RenderState::kDone : is_cancelled_ ? RenderState::kCancelled : RenderState::kFailed;
  if (const auto wanted = std::exchange(wanted_, std::nullopt)) start(wanted->first, wanted->second);
  return state_;
}

}  // namespace equilux
