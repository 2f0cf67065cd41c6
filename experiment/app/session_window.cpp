// The loop. It decides nothing: Session says what follows from an event.
#include "experiment/app/session_window.h"

#include <algorithm>

#include "base/error.h"
#include "experiment/app/screens.h"

namespace equilux {
namespace {

constexpr double kPatienceS = 0.1;  ///< between two looks at the clock when nothing happens

int count_answered(const Session& session) {
  return static_cast<int>(std::count_if(session.trials.begin(), session.trials.end(),
                                        [](const TrialRow& trial) { return trial.answer.has_value(); }));
}

bool is_leaving(const InputEvent& event) {
  return event.kind == InputKind::kKeyPress && event.key == Key::kEnter;
}

}  // namespace

SessionWindow::SessionWindow(AppWindow& window, Gui& gui, Workplace& work)
    : window_(&window), gui_(&gui), work_(&work), input_(work.layout) {}

void SessionWindow::run() {
  window_->take_events();
  while (!is_left_) {
    draw();
    window_->wait(gui_->has_events() ? 0 : kPatienceS);
    read_input();
    if (is_left_) return;
    const auto abort = input_.find_abort(read_clock_ns());
    if (abort) take(*abort);
    if (window_->is_closing()) {
      take(AbortEvent{"the window was closed", read_clock_ns()});
      return;
    }
  }
}

void SessionWindow::take(const SessionEvent& event) {
  for (const SessionEffect& effect : advance(work_->open.session, event)) carry_out(effect);
}

void SessionWindow::carry_out(const SessionEffect& effect) {
  if (const auto* shown = std::get_if<ShowTrial>(&effect)) {
    show(shown->trial);
  } else {
    record_effect(work_->log, work_->open.row.id, effect);
  }
}

void SessionWindow::show(int trial) {
  load_ahead(trial);
  shown_ = std::move(next_);
  next_.reset();
  draw_trial();
  const std::int64_t onset_ns = read_clock_ns();
  ignore_early_input();
  take(ShownEvent{trial, onset_ns});
  input_.open(onset_ns);
  if (trial + 1 < static_cast<int>(work_->open.session.trials.size())) load_ahead(trial + 1);
}

// Decoding and uploading are done while the subject looks at the pair before.
void SessionWindow::load_ahead(int trial) {
  if (next_ && next_->number == trial) return;
  const TrialRow& row = work_->open.session.trials.at(static_cast<std::size_t>(trial));
  next_ = LoadedTrial{trial, load_trial_pictures(work_->folder, work_->manifest, row)};
}

// What was pressed before the pair stood on the screen is known only as being down.
void SessionWindow::ignore_early_input() {
  window_->wait(0);
  const auto events = window_->take_events();
  gui_->skip(events);
  for (const InputEvent& event : events) input_.read(event, Screen::kTrial);
}

void SessionWindow::read_input() {
  const auto events = window_->take_events();
  if (work_->open.session.screen == Screen::kTrial) {
    gui_->skip(events);
  } else {
    gui_->take(events);
  }
  for (const InputEvent& event : events) {
    if (is_over() && is_leaving(event)) is_left_ = true;
    if (const auto meaning = input_.read(event, work_->open.session.screen)) take(*meaning);
  }
}

bool SessionWindow::is_over() const {
  const Screen screen = work_->open.session.screen;
  return screen == Screen::kThanks || screen == Screen::kAborted;
}

void SessionWindow::draw() {
  if (work_->open.session.screen != Screen::kTrial) {
    draw_page();
  } else if (window_->take_damage()) {
    draw_trial();
  }
}

void SessionWindow::draw_trial() {
  const Layout& layout = work_->layout;
  const Size size = window_->framebuffer();
  if (size != layout.framebuffer) {
    throw InputError("screen", "",
                     fmt::format("the framebuffer with which the session began, {} x {}",
                                 layout.framebuffer.width, layout.framebuffer.height),
                     fmt::format("{} x {}", size.width, size.height));
  }
  window_->clear();
  gui_->begin_frame();
  draw_question(*gui_, layout, work_->open.session.experiment);
  gui_->end_frame();
  draw_pictures(shown_->pictures, layout);
  window_->swap();
}

void SessionWindow::draw_page() {
  const Session& session = work_->open.session;
  window_->clear();
  gui_->begin_frame();
  bool is_begun = false;
  if (session.screen == Screen::kInstructions) {
    is_begun = draw_instructions(*gui_, window_->framebuffer(),
                                 {session.experiment, static_cast<int>(session.trials.size()),
                                  count_answered(session), work_->remarks});
  } else {
    is_left_ = draw_last_page() || is_left_;
  }
  gui_->end_frame();
  window_->swap();
  if (session.screen == Screen::kInstructions && session.current < static_cast<int>(session.trials.size())) {
    load_ahead(session.current);
  }
  if (is_begun) take(ContinueEvent{read_clock_ns()});
}

bool SessionWindow::draw_last_page() {
  const Session& session = work_->open.session;
  if (session.screen == Screen::kThanks) {
    return draw_message(*gui_, window_->framebuffer(), "Thank you",
                        {"That was the last question. All answers are recorded.",
                         "Please tell the experimenter that you have finished."},
                        "Close (Enter)");
  }
  return draw_message(
      *gui_, window_->framebuffer(), "The session was ended early",
      {fmt::format("{} of {} answers are recorded; none is lost.", count_answered(session),
                   session.trials.size()),
       "Please tell the experimenter. To go on where it stopped, start the same experiment with "
       "the same participant code."},
      "Close (Enter)");
}

void show_stop(AppWindow& window, Gui& gui, const std::string& message) {
  bool is_left = false;
  while (!is_left && !window.is_closing()) {
    window.clear();
    gui.begin_frame();
    is_left = draw_message(gui, window.framebuffer(), "The session has stopped",
                           {"Please call the experimenter.", message,
                            "What was recorded until now is safe. Remove the cause, then start the same "
                            "experiment with the same "
                            "participant code: it goes on at the first question without a recorded answer."},
                           "Close (Enter)");
    gui.end_frame();
    window.swap();
    window.wait(gui.has_events() ? 0 : kPatienceS);
    const auto events = window.take_events();
    gui.take(events);
    is_left = is_left || std::any_of(events.begin(), events.end(), is_leaving);
  }
}

}  // namespace equilux
