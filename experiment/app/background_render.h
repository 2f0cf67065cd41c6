// The renderer beside the window: a thread of its own, nice to the window's.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace equilux {

enum class RenderState { kIdle, kRunning, kPaused, kCancelling, kDone, kFailed, kCancelled };

/// Whether a thread is at it, or held.
bool is_active(RenderState state);

/// Renders what a study folder lacks. What is whole is kept at a cancel, and not made again. Cancelled at the
/// end of its life.
class BackgroundRender {
 public:
  BackgroundRender();
  ~BackgroundRender();
  BackgroundRender(const BackgroundRender&) = delete;
  BackgroundRender& operator=(const BackgroundRender&) = delete;

  /// While one that was cancelled is still ending, begins after it. errors: StoreError where the system gives
  /// no thread
  void start(const std::filesystem::path& study_file, const std::filesystem::path& folder);
  void pause();
  void resume();
  void cancel();

  /// Looks at the thread; gives the state.
  RenderState poll();
  /// How far it is, what it did, or why it failed.
  const std::string& line() const { return line_; }

 private:
  struct Run;

  RenderState state_ = RenderState::kIdle;
  std::unique_ptr<Run> run_;
  std::optional<std::pair<std::filesystem::path, std::filesystem::path>> wanted_;  ///< study, folder
  std::string line_;
};

}  // namespace equilux
