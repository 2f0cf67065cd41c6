// make_set in a thread, held and ended by its control.
#include "experiment/app/background_render.h"

#include <atomic>
#include <new>
#include <sys/resource.h>
#include <system_error>
#include <thread>

#include "base/error.h"
#include "base/work_control.h"
#include "renderer/set.h"

namespace equilux {
namespace {

constexpr int kNiceness = 10;  // the window comes first

// Of this thread, and of those that it begins.
void be_nice() { ::setpriority(PRIO_PROCESS, 0, kNiceness); }

// What a set is beyond, which a session or `verify` would refuse it for, or what is hardly ever meant.
std::string tell_faults(const SetSummary& summary) {
  const auto tell = [](const std::string& what, std::size_t count, const std::string& first) {
    return fmt::format("; {}: {}{}", what, count > 1 ? fmt::format("{}, the first ", count) : "", first);
  };
  std::string text;
  if (!summary.missed.empty())
    text += tell("BEYOND ITS LIMIT", summary.missed.size(), summary.missed.front());
  if (!summary.findings.empty())
    text += tell("FOUND WRONG", summary.findings.size(), format_finding(summary.findings.front()));
  if (!summary.warnings.empty()) text += tell("warning", summary.warnings.size(), summary.warnings.front());
  return text;
}

}  // namespace

bool is_active(RenderState state) {
  return state == RenderState::kRunning || state == RenderState::kPaused || state == RenderState::kCancelling;
}

// Its thread writes the outcome, and is over then.
struct BackgroundRender::Run {
  Run(const std::filesystem::path& study_file, const std::filesystem::path& folder) {
    params.study_path = study_file;
    params.folder = folder;
    control.tell("starting");
    thread = std::jthread([this] { outcome = make(); });
  }

  RenderState make() {
    be_nice();
    const ControlledWork work(control);
    try {
      const SetSummary summary = make_set(params);
      control.tell(fmt::format("{} pictures, {} of them made now{}", summary.pictures,
                               summary.pictures_written, tell_faults(summary)));
      return RenderState::kDone;
    } catch (const WorkCancelled&) {
      return RenderState::kCancelled;
    } catch (const std::bad_alloc&) {
      control.tell("out of memory");
    } catch (const std::exception& error) {
      control.tell(error.what());
    }
    return RenderState::kFailed;
  }

  WorkControl control;
  SetParams params;
  std::atomic<RenderState> outcome = RenderState::kRunning;
  std::jthread thread;  // ends before what it uses
};

BackgroundRender::BackgroundRender() = default;

BackgroundRender::~BackgroundRender() { cancel(); }

void BackgroundRender::start(const std::filesystem::path& study_file, const std::filesystem::path& folder) {
  if (run_) {
    if (state_ == RenderState::kCancelling) wanted_.emplace(study_file, folder);
    return;
  }
  try {
    run_ = std::make_unique<Run>(study_file, folder);
  } catch (const std::system_error& error) {
    throw StoreError(fmt::format("cannot start a thread: {}", error.what()));
  }
  state_ = RenderState::kRunning;
  line_ = run_->control.line();
}

void BackgroundRender::pause() {
  if (state_ != RenderState::kRunning) return;
  run_->control.pause();
  state_ = RenderState::kPaused;
}

void BackgroundRender::resume() {
  if (state_ != RenderState::kPaused) return;
  run_->control.resume();
  state_ = RenderState::kRunning;
}

void BackgroundRender::cancel() {
  wanted_.reset();
  if (!run_) return;
  run_->control.cancel();
  state_ = RenderState::kCancelling;
}

RenderState BackgroundRender::poll() {
  if (!run_) return state_;
  const RenderState outcome = run_->outcome;
  line_ = run_->control.line();
  if (outcome == RenderState::kRunning) return state_;
  state_ = outcome;
  run_.reset();
  if (const auto wanted = std::exchange(wanted_, std::nullopt)) start(wanted->first, wanted->second);
  return state_;
}

}  // namespace equilux
