// Loops around pages: draw, wait, read.
#include "experiment/app/intake_window.h"

#include <deque>
#include <functional>

#include "experiment/app/screens.h"

namespace equilux {
namespace {

constexpr double kPatienceS = 0.1;

bool is_press(const InputEvent& event, Key key) {
  return event.kind == InputKind::kKeyPress && event.key == key;
}

// One page: `draw` lays it out and tells whether its button was pressed, `read` whether a key leaves it.
// False if the window was closed.
bool run_page(AppWindow& window, Gui& gui, const std::function<bool()>& draw,
              const std::function<bool(const InputEvent&)>& read) {
  window.take_events();
  std::deque<InputEvent> waiting;  // each is read when what came before it has been laid out
  bool is_left = false;
  while (!is_left) {
    window.clear();
    gui.begin_frame();
    is_left = draw();
    gui.end_frame();
    window.swap();
    if (is_left) break;
    window.wait(gui.has_events() || !waiting.empty() ? 0 : kPatienceS);
    for (const InputEvent& event : window.take_events()) waiting.push_back(event);
    if (!gui.has_events() && !waiting.empty()) {
      const InputEvent event = waiting.front();
      waiting.pop_front();
      gui.take({event});
      is_left = read(event);
    }
    if (window.is_closing()) return false;
  }
  return true;
}

}  // namespace

bool ask_setup(AppWindow& window, Gui& gui, Workplace& work) {
  SetupForm form = make_setup_form(work.setup_input.diagonal_m, work.setup.viewing_distance_m);
  const Size picture{work.manifest.width, work.manifest.height};
  const auto draw = [&] {
    set_up(work, read_setup_form(form));
    const SetupView view{&work.facts, &work.setup, find_least_framebuffer(picture), work.request.participant,
                         format_experiment(work.inputs.experiment)};
    return draw_setup(gui, window.framebuffer(), view, form);
  };
  const auto read = [&](const InputEvent& event) {
    constexpr int kFirstCardPx = 320;
    if (is_press(event, Key::kF3)) form.card_px = form.card_px > 0 ? 0 : kFirstCardPx;
    return is_press(event, Key::kEnter);
  };
  const bool is_left = run_page(window, gui, draw, read);
  set_up(work, read_setup_form(form));
  return is_left;
}

Intake ask_intake(AppWindow& window, Gui& gui, const Workplace& work) {
  const SessionProtocol& protocol = work.inputs.protocol;
  Intake intake = make_intake(protocol);
  if (intake.step == IntakeStep::kConsent) {
    const auto draw = [&] {
      const auto choice = draw_consent(gui, window.framebuffer(), work.texts, *protocol.consent);
      if (choice) give_consent(intake, protocol, *choice);
      return intake.step != IntakeStep::kConsent;
    };
    const auto read = [&](const InputEvent& event) {
      if (is_press(event, Key::kEnter)) give_consent(intake, protocol, true);
      if (is_press(event, Key::kBackspace)) give_consent(intake, protocol, false);
      return intake.step != IntakeStep::kConsent;
    };
    if (!run_page(window, gui, draw, read)) return intake;
  }
  if (intake.step == IntakeStep::kQuestions) {
    bool is_reminded = false;
    const auto submit = [&] {
      submit_answers(intake, protocol);
      is_reminded = true;
    };
    const auto draw = [&] {
      if (draw_questions(gui, window.framebuffer(), work.texts, protocol, intake, is_reminded)) submit();
      return intake.step != IntakeStep::kQuestions;
    };
    const auto read = [&](const InputEvent& event) {
      if (is_press(event, Key::kEnter)) submit();
      return intake.step != IntakeStep::kQuestions;
    };
    run_page(window, gui, draw, read);
  }
  return intake;
}

void show_message(AppWindow& window, Gui& gui, const std::string& title,
                  const std::vector<std::string>& paragraphs, const std::string& button) {
  run_page(
      window, gui, [&] { return draw_message(gui, window.framebuffer(), title, paragraphs, button); },
      [](const InputEvent& event) { return is_press(event, Key::kEnter); });
}

}  // namespace equilux
