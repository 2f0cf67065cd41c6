// From the start screen to the thanks.
#include "experiment/app/app.h"

#include <algorithm>
#include <deque>
#include <fmt/format.h>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/program.h"
#include "experiment/app/gui.h"
#include "experiment/app/intake_window.h"
#include "experiment/app/screens.h"
#include "experiment/app/session_window.h"
#include "experiment/app/stop.h"
#include "experiment/app/window.h"
#include "experiment/app/workplace.h"

namespace equilux {
namespace {

constexpr double kPatienceS = 0.1;
// ImGui 1.86 moves the keyboard into a field over some frames, and drops what is typed meanwhile.
constexpr int kFramesToFocus = 4;

std::unique_ptr<AppWindow> open_window(const AppParams& params, const Display& display) {
  const Size screen = display.size();
  Size size{std::min(kPageSize.width, screen.width), std::min(kPageSize.height, screen.height)};
  if (is_complete(params)) size = choose_window_size(params, display);
  return params.windowed ? std::make_unique<AppWindow>(display, size) : std::make_unique<AppWindow>(display);
}

// A code that nobody in the folder's log has, as far as it can be read.
std::string draw_free_code(const std::filesystem::path& study_folder) {
  std::vector<std::string> taken;
  const StudyFolder folder{study_folder};
  if (TrialLog::is_at(folder.responses())) {
    const TrialLog log = TrialLog::load_snapshot(folder.responses());
    for (const SessionRow& row : log.load_sessions()) taken.push_back(row.participant);
  }
  return draw_code(taken);
}

void fill_in_interrupted(StartForm& form) {
  const auto row = find_interrupted({read_folder(form)});
  if (!row) throw InputError("Participant code", "", "a session that was interrupted", "none in this folder");
  set_participant(form, row->participant);
  set_experiment(form, row->experiment);
}

// What the keyboard does on the start screen beside typing; true for the key that submits.
bool read_start_key(const InputEvent& event, StartForm& form) {
  if (event.kind != InputKind::kKeyPress) return false;
  if (event.key == Key::kF1) form.experiment = 0;
  if (event.key == Key::kF2) form.experiment = 1;
  return event.key == Key::kEnter;
}

// One frame of the start screen; true when its button was pressed.
bool draw_start_frame(AppWindow& window, Gui& gui, StartForm& form) {
  window.clear();
  gui.begin_frame();
  const bool is_pressed = draw_start(gui, window.framebuffer(), form);
  gui.end_frame();
  window.swap();
  return is_pressed;
}

// A code drawn or looked up. An error stays on the screen until the next try.
void fill_in(StartForm& form, Key key) {
  try {
    key == Key::kF3 ? set_participant(form, draw_free_code(read_folder(form))) : fill_in_interrupted(form);
    form.error.clear();
  } catch (const std::exception& error) {
    form.error = error.what();
  }
}

// What was done on the start screen. What follows Enter waits until that was tried and a field is ready
// again.
struct StartInput {
  std::deque<InputEvent> waiting;
  bool is_submitted = false;
  PageGuard guard;
  EscapeHold escape;
};

void read_start_input(Gui& gui, StartForm& form, StartInput& input) {
  while (!input.is_submitted && !input.waiting.empty()) {
    InputEvent event = input.waiting.front();
    const bool fills_in =
        event.kind == InputKind::kKeyPress && (event.key == Key::kF3 || event.key == Key::kF4);
    if (fills_in && gui.has_events()) return;  // what was typed before it comes first
    input.waiting.pop_front();
    gui.take({event});
    if (fills_in) {
      gui.leave_field();
      fill_in(form, event.key);
    }
    input.is_submitted = read_start_key(event, form);
    if (!input.is_submitted) continue;
    event.kind = InputKind::kKeyRelease;  // else ImGui repeats an Enter that seems held, and leaves the field
    gui.take({event});
  }
}

// Draws the start screen and reads what was done; true when all of it is on the screen and is to be tried.
bool ask(AppWindow& window, Gui& gui, StartForm& form, StartInput& input) {
  const int frames = form.takes_focus ? kFramesToFocus : 1;
  for (int i = 0; i < frames; ++i) {
    input.is_submitted = draw_start_frame(window, gui, form) || input.is_submitted;
  }
  if (!gui.has_events() && std::exchange(input.is_submitted, false)) return true;
  window.wait(gui.has_events() || !input.waiting.empty() ? 0 : kPatienceS);
  for (const InputEvent& event : window.take_events()) {
    input.escape.read(event);
    if (input.guard.admit(event)) input.waiting.push_back(event);
  }
  if (input.escape.take(read_clock_ns())) window.close();
  read_start_input(gui, form, input);
  return false;
}

// Whatever the subject is to read can be shown.
Workplace prepare(const AppParams& params, const Display& display, AppWindow& window, Gui& gui) {
  Workplace work = prepare_workplace(params, display, window);
  gui.use_texts(list_shown_texts(work.folder(), work.inputs.protocol, work.texts));
  return work;
}

// Empty if the window was closed. Errors stay on the screen until the next try.
std::optional<Workplace> ask_for_workplace(const AppParams& params, const Display& display, AppWindow& window,
                                           Gui& gui) {
  StartForm form = make_start_form(params);
  StartInput input;
  for (int i = 0; i < kFramesToFocus; ++i) draw_start_frame(window, gui, form);
  open_guard(window, gui, input.guard);
  while (!window.is_closing()) {
    if (!ask(window, gui, form, input)) continue;
    form.takes_focus = true;
    try {
      return prepare(read_start_form(form, params), display, window, gui);
    } catch (const InputError& error) {
      form.error = error.what();
    } catch (const StoreError& error) {
      form.error = error.what();
    }
  }
  return std::nullopt;
}

void print_latencies(std::vector<std::int64_t> latencies_ns) {
  if (latencies_ns.empty()) return;
  std::sort(latencies_ns.begin(), latencies_ns.end());
  const auto at = [&](double share) {
    const auto place = static_cast<std::size_t>(share * static_cast<double>(latencies_ns.size() - 1));
    return 1e-6 * static_cast<double>(latencies_ns[place]);
  };
  fmt::print("  from an answer to the next pair on the screen: median {:.1f} ms, 99 % within {:.1f} ms\n",
             at(.5), at(.99));
}

std::string describe_end(const Session& session, const SessionInputs& inputs) {
  if (session.screen == Screen::kThanks) return "is complete";
  const char* end =
      session.screen == Screen::kInterrupted ? "was interrupted: the window was closed" : "was ended early";
  return fmt::format("{}; {}", end, describe_way_on(inputs));
}

void print_outcome(const Workplace& work, const Seat& seat) {
  const Session& session = seat.open.session;
  const std::string name = format_experiment(session.experiment), code = seat.open.row.participant;
  fmt::print("{} session of {} {}:\n", name, code, describe_end(session, work.inputs));
  for (const std::string& line : summarise(session, work.inputs.protocol, seat.notes))
    fmt::print("  {}\n", line);
  print_latencies(seat.latencies_ns);
}

// Empty if the window was closed, or the participant declined.
std::optional<Seat> come_in(AppWindow& window, Gui& gui, Workplace& work, Display& display, bool is_asked) {
  const bool is_age_doubtful = work.goes_on && work.clock_lag && work.inputs.kind == SubjectKind::kPerson;
  const bool asks_setup = is_asked || is_age_doubtful;
  if (asks_setup && !ask_setup(window, gui, work, display)) return std::nullopt;
  work.is_set_up = work.request.accepts_clock = asks_setup;
  if (work.goes_on || work.inputs.kind != SubjectKind::kPerson) return take_seat(work, {});
  const Intake intake = ask_intake(window, gui, work);
  if (intake.step == IntakeStep::kDone) return take_seat(work, find_fields(intake, work.inputs.protocol));
  if (intake.step == IntakeStep::kDeclined) {
    show_message(window, gui,
                 {work.texts.at("declined_title"),
                  {work.texts.at("declined_text")},
                  work.texts.at("close"),
                  work.texts.at("more_below")});
  }
  fmt::print("no session was begun: {}\n", intake.step == IntakeStep::kDeclined
                                               ? "the participant does not take part"
                                               : "the window was closed");
  return std::nullopt;
}

std::optional<PlantedPilot> make_pilot(const AppParams& params, const Workplace& work, const Seat& seat) {
  if (!params.planted_seed) return std::nullopt;
  const SessionRow& row = seat.open.row;
  return PlantedPilot{load_truth(work.folder().truth(), work.inputs.study),
                      {row.seed, row.experiment, row.subject_index},
                      params.pace};
}

// The next planted subject of this seed, as the headless program would call it.
std::string name_planted_subject(const AppParams& params) {
  const StudyFolder folder{params.study_folder};
  const std::uint64_t seed = *params.planted_seed;
  if (!TrialLog::is_at(folder.responses())) return name_planted(seed, find_lane(nullptr, params.lane).first);
  const TrialLog log = TrialLog::load_snapshot(folder.responses());
  return name_next_planted(
      log, seed,
      log.find_free_index(SubjectKind::kPlanted, *params.experiment, find_lane(&log, params.lane)));
}

}  // namespace

int run_app(const AppParams& given) {
  AppParams params = given;
  if (params.participant == "new") params.participant = draw_free_code(params.study_folder);
  if (params.planted_seed && params.participant.empty()) params.participant = name_planted_subject(params);
  Display display(params.monitor);
  const auto window = open_window(params, display);
  Gui gui(*window, static_cast<float>(params.text_scale));
  const bool is_asked = !is_complete(params);
  auto work = is_asked ? ask_for_workplace(params, display, *window, gui)
                       : std::optional(prepare(params, display, *window, gui));
  if (!work) return kExitOk;
  std::optional<Seat> seat;
  try {
    seat = come_in(*window, gui, *work, display, is_asked || params.asks_setup);
    if (!seat) return kExitOk;
    SessionWindow(*window, gui, *work, *seat, make_pilot(params, *work, *seat)).run();
  } catch (const std::exception& error) {
    if (seat) record_stop(*seat, error.what());
    // A planted subject has nobody beside it who could read and close the screen.
    if (!params.planted_seed) {
      const StopState not_seated = work->goes_on ? StopState::kUnfinished : StopState::kNotBegun;
      show_stop(*window, gui, *work, seat ? find_stop_state(*seat) : not_seated, error.what());
    }
    throw;
  }
  print_outcome(*work, *seat);
  return kExitOk;
}

}  // namespace equilux
