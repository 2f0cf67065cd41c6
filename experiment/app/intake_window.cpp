// Loops around pages: draw, wait, read.
#include "experiment/app/intake_window.h"

#include <deque>
#include <fmt/format.h>
#include <functional>
#include <utility>

#include "base/error.h"
#include "experiment/app/screens.h"

namespace equilux {
namespace {

constexpr double kPatienceS = 0.1;

bool is_press(const InputEvent& event, Key key) {
  return event.kind == InputKind::kKeyPress && event.key == key;
}

// A page, and how long it takes no press.
struct RunningPage {
  std::function<bool()> draw;                   ///< lays it out; tells whether its button was pressed
  std::function<bool(const InputEvent&)> read;  ///< whether a key leaves it
  std::int64_t guard_ns = kPageGuardNs;
  bool needs_quiet = false;
  std::function<bool()> prepare = {};  ///< what is to be done to the window, between frames; whether it was
};

// ImGui moves its frame to another control in the frame after the one that saw the key.
constexpr int kFramesToMove = 2;
// It knows after some how long a page is, and what is to be said below it.
constexpr int kFramesToSettle = 4;

bool draw_frames(AppWindow& window, Gui& gui, const RunningPage& page, int frames) {
  bool is_left = false;
  for (int i = 0; i < frames && !is_left; ++i) {
    window.clear();
    gui.begin_frame();
    is_left = page.draw();
    gui.end_frame();
    window.swap();
  }
  return is_left;
}

// False if the window was closed, or Escape held: nothing is recorded yet, or nothing more.
bool run_page(AppWindow& window, Gui& gui, const RunningPage& page) {
  if (draw_frames(window, gui, page, 1)) return true;
  PageGuard guard;
  open_guard(window, gui, guard, page.guard_ns, page.needs_quiet);
  if (draw_frames(window, gui, page, kFramesToSettle)) return true;
  EscapeHold escape;
  std::deque<InputEvent> waiting;  // each is read when what came before it has been laid out
  while (!window.is_closing()) {
    const bool was_key = gui.has_events();
    if (draw_frames(window, gui, page, was_key ? kFramesToMove : 1)) return true;
    if (page.prepare && page.prepare()) {  // what was pressed meanwhile was for the page as it was
      waiting.clear();
      open_guard(window, gui, guard, page.guard_ns, page.needs_quiet);
    }
    window.wait(gui.has_events() || !waiting.empty() ? 0 : kPatienceS);
    for (const InputEvent& event : window.take_events()) {
      escape.read(event);
      if (guard.admit(event)) waiting.push_back(event);
    }
    if (escape.take(read_clock_ns())) window.close();
    if (gui.has_events() || waiting.empty()) continue;
    const InputEvent event = waiting.front();
    waiting.pop_front();
    gui.take({event});
    if (page.read(event)) return true;
  }
  return false;
}

Intake ask_consent(AppWindow& window, Gui& gui, const Workplace& work, Intake intake) {
  const SessionProtocol& protocol = work.inputs.protocol;
  ConsentForm form;
  const auto take = [&](const std::optional<bool>& choice) {
    if (choice) give_consent(intake, protocol, *choice);
    return choice.has_value();
  };
  run_page(
      window, gui,
      {[&] { return take(draw_consent(gui, window.framebuffer(), work.texts, *protocol.consent, form)); },
       [&](const InputEvent& event) {
         return event.kind == InputKind::kKeyPress && take(find_choice(form, event.key));
       },
       kConsentGuardNs, true});
  return intake;
}

Intake ask_questions(AppWindow& window, Gui& gui, const Workplace& work, Intake intake) {
  const SessionProtocol& protocol = work.inputs.protocol;
  bool is_reminded = false;
  const auto submit = [&](bool is_wanted) {
    if (!is_wanted) return false;
    submit_answers(intake, protocol);
    is_reminded = true;
    return intake.step != IntakeStep::kQuestions;
  };
  run_page(
      window, gui,
      {[&] {
         return submit(draw_questions(gui, window.framebuffer(), work.texts, protocol, intake, is_reminded));
       },
       [&](const InputEvent& event) { return submit(is_press(event, Key::kEnter)); }});
  return intake;
}

// After the one that was tried last, so that one that cannot be used stands in no other's way.
void want_next_monitor(SetupForm& form, const Display& display) {
  const std::string& last = form.tried_monitor.empty() ? display.monitor_name() : form.tried_monitor;
  form.wanted_monitor = find_next_monitor(display.list_monitor_names(), last);
}

// True if it was tried.
bool move_if_wanted(AppWindow& window, Workplace& work, Display& display, SetupForm& form) {
  const std::string name = std::exchange(form.wanted_monitor, "");
  if (name.empty()) return false;
  form.tried_monitor = name;
  if (name == display.monitor_name() && !window.has_lost_monitor()) return false;
  try {
    change_monitor(work, display, window, name);
    forget_monitor(form);
    form.error.clear();
  } catch (const InputError& error) {
    form.error = fmt::format("Monitor {} cannot be used. {}", name, error.what());
  }
  return true;
}

}  // namespace

bool ask_setup(AppWindow& window, Gui& gui, Workplace& work, Display& display) {
  SetupForm form = make_setup_form(work.setup_input.diagonal_m, work.setup_input.viewing_distance_m);
  const Size picture{work.manifest.width, work.manifest.height};
  const auto draw = [&] {
    set_up(work, read_setup_form(form));
    const SetupView view{&work.facts,
                         &work.setup,
                         work.inputs.study.viewing_distance_m,
                         find_least_framebuffer(picture),
                         work.request.participant,
                         format_experiment(work.inputs.experiment),
                         work.goes_on_with,
                         describe_clock(work),
                         display.list_monitor_names()};
    return draw_setup(gui, window.framebuffer(), view, form);
  };
  const auto read = [&](const InputEvent& event) {
    if (is_press(event, Key::kF3)) switch_card(form);
    if (is_press(event, Key::kF5)) want_next_monitor(form, display);
    return is_press(event, Key::kEnter) && leave_setup(form);
  };
  const auto prepare = [&] { return move_if_wanted(window, work, display, form); };
  const bool is_left = run_page(window, gui, {draw, read, kPageGuardNs, false, prepare});
  set_up(work, read_setup_form(form));
  return is_left;
}

Intake ask_intake(AppWindow& window, Gui& gui, const Workplace& work) {
  Intake intake = make_intake(work.inputs.protocol);
  if (intake.step == IntakeStep::kConsent) intake = ask_consent(window, gui, work, intake);
  if (intake.step == IntakeStep::kQuestions) intake = ask_questions(window, gui, work, intake);
  return intake;
}

void show_message(AppWindow& window, Gui& gui, const MessageText& text) {
  run_page(window, gui,
           {[&] { return draw_message(gui, window.framebuffer(), text); },
            [](const InputEvent& event) { return is_press(event, Key::kEnter); }});
}

void open_guard(AppWindow& window, Gui& gui, PageGuard& guard, std::int64_t guard_ns, bool needs_quiet) {
  window.wait(0);
  const auto events = window.take_events();
  for (const InputEvent& event : events) guard.admit(event);
  gui.skip(events);
  guard.open(read_clock_ns(), guard_ns, needs_quiet);
}

}  // namespace equilux
