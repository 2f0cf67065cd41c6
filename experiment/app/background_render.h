// equilux-render beside the window: a process of its own, so that neither can end the other.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <sys/types.h>
#include <utility>

namespace equilux {

enum class RenderState { kIdle, kRunning, kPaused, kDone, kFailed, kCancelled };

/// Renders what a study folder lacks. What is whole is kept at a cancel, and not made again. Cancelled at the
/// end of its life.
class BackgroundRender {
 public:
  BackgroundRender() = default;
  ~BackgroundRender();
  BackgroundRender(const BackgroundRender&) = delete;
  BackgroundRender& operator=(const BackgroundRender&) = delete;

  /// While one that was cancelled is still ending, begins after it. errors: StoreError if the program cannot
  /// be started
  void start(const std::filesystem::path& study_file, const std::filesystem::path& folder);
  void pause();
  void resume();
  void cancel();

  /// Looks at the process; gives the state.
  RenderState poll();
  /// The last line that it wrote: its progress, or why it failed.
  const std::string& line() const { return line_; }

 private:
  void read_output();

  RenderState state_ = RenderState::kIdle;
  pid_t pid_ = -1;
  int output_ = -1;
  bool is_cancelled_ = false;
  std::optional<std::pair<std::filesystem::path, std::filesystem::path>> wanted_;  ///< study, folder
  std::string partial_;
  std::string line_;
};

}  // namespace equilux
