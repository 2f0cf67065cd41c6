// make_set in a thread, held and ended by its control.
#include "experiment/app/background_render.h"

#include <atomic>
#include <fmt/format.h>
#include <sys/resource.h>
#include <thread>

#include "renderer/set.h"

namespace equilux {
namespace {

constexpr int kNiceness = 10;  // the window comes first

// Of this thread, and of those that it begins.
void be_nice() { ::setpriority(PRIO_PROCESS, 0, kNiceness); }

}  // namespace

// Its thread writes outcome and line, and is over then.
struct BackgroundRender::Job {
  Job(const std::filesystem::path& study_file, const std::filesystem::path& folder) {
    params.study_path = study_file;
    params.folder = folder;
    params.control = &control;
    control.tell("starting");
    thread = std::jthread([this] { run(); });
  }

  void run() {
    be_nice();
    RenderState outcome = RenderState::kDone;
    try {
      const SetSummary summary = make_set(params);
      control.tell(
          fmt::format("{} pictures, {} of them made now", summary.pictures, summary.pictures_written));
    } catch (const JobCancelled&) {
      outcome = RenderState::kCancelled;
    } catch (const std::bad_alloc&) {
      outcome = RenderState::kFailed;
      control.tell("out of memory");
    } catch (const std::exception& error) {
      outcome = RenderState::kFailed;
      control.tell(error.what());
    }
    state = outcome;
  }

  JobControl control;
  SetParams params;
  std::atomic<RenderState> state = RenderState::kRunning;
  bool is_cancelled = false;
  std::jthread thread;  // ends before what it uses
};

BackgroundRender::BackgroundRender() = default;

BackgroundRender::~BackgroundRender() { cancel(); }

void BackgroundRender::start(const std::filesystem::path& study_file, const std::filesystem::path& folder) {
  if (job_) {
    if (job_->is_cancelled) wanted_.emplace(study_file, folder);
    return;
  }
  job_ = std::make_unique<Job>(study_file, folder);
  state_ = RenderState::kRunning;
  line_ = job_->control.line();
}

void BackgroundRender::pause() {
  if (state_ != RenderState::kRunning) return;
  job_->control.pause();
  state_ = RenderState::kPaused;
}

void BackgroundRender::resume() {
  if (state_ != RenderState::kPaused) return;
  job_->control.resume();
  state_ = RenderState::kRunning;
}

void BackgroundRender::cancel() {
  if (!job_) return;
  job_->is_cancelled = true;
  wanted_.reset();
  job_->control.cancel();
}

RenderState BackgroundRender::poll() {
  if (!job_) return state_;
  const RenderState state = job_->state;
  line_ = job_->control.line();
  if (state == RenderState::kRunning) return state_;
  state_ = state;
  job_.reset();
  if (const auto wanted = std::exchange(wanted_, std::nullopt)) start(wanted->first, wanted->second);
  return state_;
}

}  // namespace equilux
