// The loop. It decides nothing: Session says what follows from an event.
#include "experiment/app/session_window.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/error.h"
#include "experiment/app/intake_window.h"
#include "experiment/app/pages.h"

namespace equilux {
namespace {

constexpr double kPatienceS = 0.1;  // between two looks at the clock when nothing happens
constexpr double kPilotPatienceS = 0.002;

bool is_main(const TrialRow& trial) { return trial.phase != Phase::kPractice; }

int count_main(const Session& session, bool answered_only) {
  return static_cast<int>(std::count_if(
      session.trials.begin(), session.trials.end(),
      [&](const TrialRow& trial) { return is_main(trial) && (!answered_only || trial.answer.has_value()); }));
}

int count_practice(const Session& session) {
  return static_cast<int>(session.trials.size()) - count_main(session, false);
}

int count_object_pages(const std::vector<FamiliarPage>& pages) {
  return static_cast<int>(std::count_if(pages.begin(), pages.end(),
                                        [](const FamiliarPage& page) { return page.right_key.empty(); }));
}

// None before all were answered.
std::string find_verdict(const CatchTrials& asked, int caught, int answered) {
  if (answered < asked.count) return "; not all were answered";
  return caught >= asked.pass ? "" : ": NOT PASSED";
}

std::string number(int value) { return fmt::format("{}", value); }

// That stand on the set-up screen, where it is shown.
std::vector<std::string> list_remarks(const Workplace& work) {
  std::vector<std::string> remarks = work.setup.remarks;
  if (work.clock_lag) remarks.push_back(describe_clock(work));
  return remarks;
}

bool is_press(const InputEvent& event, Key key) {
  return event.kind == InputKind::kKeyPress && event.key == key;
}

}  // namespace

std::vector<std::string> summarise(const Session& session, const SessionProtocol& protocol,
                                   const std::map<std::string, int>& notes) {
  int catches = 0, caught = 0, fast = 0;
  for (const TrialRow& trial : session.trials) {
    if (!trial.answer) continue;
    fast += is_main(trial) && trial.too_fast ? 1 : 0;
    if (trial.phase != Phase::kCatch) continue;
    ++catches;
    caught += trial.answer == trial.test_side ? 1 : 0;
  }
  std::vector<std::string> lines{
      fmt::format("{} of {} answers.", count_main(session, true), count_main(session, false))};
  if (protocol.catch_trials) {
    lines.push_back(fmt::format("Catch trials: {} of {} right; {} is asked of a subject who attends{}.",
                                caught, catches, protocol.catch_trials->pass,
                                find_verdict(*protocol.catch_trials, caught, catches)));
  }
  if (protocol.least_response_ms > 0)
    lines.push_back(fmt::format("Answers in less than {} ms: {}.", protocol.least_response_ms, fast));
  for (const auto& [kind, count] : notes) lines.push_back(fmt::format("{}: {}", kind, count));
  return lines;
}

std::string describe_way_on(const SessionInputs& inputs) {
  const SessionProtocol& protocol = inputs.protocol;
  if (inputs.kind == SubjectKind::kPerson && !protocol.may_resume)
    return "the protocol lets nobody go on with it";
  std::string text = "the same command with this code goes on with it";
  if (inputs.kind == SubjectKind::kPerson && protocol.resume_within_hours)
    text += fmt::format(", within {} hours of its last answer", *protocol.resume_within_hours);
  return text;
}

SessionWindow::SessionWindow(AppWindow& window, Gui& gui, const Workplace& work, Seat& seat,
                             const std::optional<PlantedPilot>& pilot)
    : window_(&window), gui_(&gui), work_(&work), seat_(&seat), pilot_(pilot), input_(work.layout) {}

void SessionWindow::run() {
  window_->wait(0);  // the focus comes and goes while a window opens, which disturbs nobody
  window_->take_changes();
  while (!is_left_) {
    const bool is_new = std::exchange(is_new_page_, false);
    draw();
    if (is_new) open_new_page();
    window_->wait(gui_->has_events() ? 0 : pilot_ ? kPilotPatienceS : kPatienceS);
    note_changes();
    pause_unless_it_fits();  // before an answer to a pair that is not as it was
    read_input();
    upload_ahead();
    if (pilot_) fly();
    if (is_left_) return;
    if (const auto pause = input_.find_pause(read_clock_ns())) take(*pause);
    if (window_->is_closing()) {
      take(InterruptEvent{"the window was closed", read_clock_ns()});
      return;
    }
  }
}

void SessionWindow::take(const SessionEvent& event) {
  const auto* answer = std::get_if<AnswerEvent>(&event);
  answered_ns_ = answer ? std::optional(read_clock_ns()) : std::nullopt;
  const Screen before = session().screen;
  const int page_before = session().page;
  for (const SessionEffect& effect : advance(session(), event)) carry_out(effect);
  if (session().screen == before && session().page == page_before) return;
  is_new_page_ = session().screen != Screen::kTrial;
  input_.open_page(read_clock_ns());
  gui_->skip({});  // what led here presses nothing on the next page
}

// Nothing that was done before the page was on the screen is done to it.
void SessionWindow::open_new_page() {
  ignore_early_input();
  input_.open_page(read_clock_ns());
}

void SessionWindow::carry_out(const SessionEffect& effect) {
  if (const auto* shown = std::get_if<ShowTrial>(&effect)) {
    show(shown->trial);
    return;
  }
  record_effect(seat_->log, seat_->open.row.id, effect);
  if (const auto* note = std::get_if<RecordNote>(&effect)) ++seat_->notes[note->kind];
  if (std::holds_alternative<RecordAbort>(effect)) ++seat_->notes["abort"];
  // The last page may stand for hours, and somebody may copy the log meanwhile.
  if (is_over()) seat_->log.empty_wal();
}

void SessionWindow::show(int trial) {
  pause_unless_it_fits();
  if (session().screen != Screen::kTrial) return;
  load_ahead(trial);
  if (loading_ && loading_->number == trial) finish_loading();
  shown_ = std::move(next_);
  next_.reset();
  const std::int64_t begin_ns = read_clock_ns();
  draw_trial();
  const std::int64_t onset_ns = read_clock_ns();
  if (answered_ns_) seat_->latencies_ns.push_back(onset_ns - *answered_ns_);
  ignore_early_input();
  take(ShownEvent{trial, onset_ns});
  input_.open(onset_ns);
  const std::int64_t took_ns = onset_ns - begin_ns;
  if (is_slow_showing(took_ns, work_->facts)) {
    const double took_ms = static_cast<double>(took_ns) / 1e6;
    take(NoteEvent{"slow_frame", fmt::format("trial {}: {:.0f} ms", trial, took_ms), onset_ns});
  }
  if (trial + 1 < static_cast<int>(session().trials.size())) load_ahead(trial + 1);
}

// Files are read and decoded beside the window, which takes every press when it comes, however slow the disk.
void SessionWindow::load_ahead(int trial) {
  if (next_ && next_->number == trial) return;
  if (loading_ && loading_->number == trial) return;
  if (shown_ && shown_->number == trial) {  // after a pause
    next_ = std::move(shown_);
    shown_.reset();
    return;
  }
  next_.reset();
  const TrialRow& row = session().trials.at(static_cast<std::size_t>(trial));
  loading_ = LoadingTrial{trial, std::async(std::launch::async, [work = work_, row] {
                            std::vector<LdrImage> images =
                                load_trial_images(work->folder(), work->manifest, row);
                            AppWindow::wake();
                            return images;
                          })};
}

void SessionWindow::finish_loading() {
  LoadingTrial loading = std::move(*loading_);
  loading_.reset();
  next_ = LoadedTrial{loading.number, upload_trial(loading.images.get())};
}

// Into the graphics card while the subject looks at the pair before.
void SessionWindow::upload_ahead() {
  constexpr std::chrono::seconds kNow(0);
  if (!next_ && loading_ && loading_->images.wait_for(kNow) == std::future_status::ready) finish_loading();
}

// The planted subject in the person's place.
void SessionWindow::fly() {
  if (is_over()) {
    is_left_ = true;
    return;
  }
  if (session().screen == Screen::kPause) return check_screen();
  const std::int64_t now_ns = read_clock_ns();
  if (session().screen != Screen::kTrial) {
    take(ContinueEvent{now_ns});
    return;
  }
  const TrialRow& trial = session().trials.at(static_cast<std::size_t>(session().current));
  const auto response_ns = static_cast<double>(draw_planted_response_time_ns(pilot_->subject, trial.number));
  if (!session().onset_ns || static_cast<double>(now_ns - *session().onset_ns) < pilot_->pace * response_ns)
    return;
  const Side side = choose_planted_side(pilot_->truth, pilot_->subject, trial);
  take(AnswerEvent{side, std::max(now_ns, *session().onset_ns + 1)});
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
  for (const InputEvent& event : events) {
    const Screen screen = session().screen;
    const auto meaning = input_.read(event, screen);
    if (screen != Screen::kTrial && input_.is_admitted()) {
      gui_->take({event});
      read_page_key(event);
    } else {
      gui_->skip({event});
    }
    if (meaning) take(*meaning);
  }
}

// Beside those that lead on in the session.
void SessionWindow::read_page_key(const InputEvent& event) {
  if (is_over() && is_press(event, Key::kEnter)) is_left_ = true;
  if (is_over() && is_press(event, Key::kF3)) shows_summary_ = !shows_summary_;
  if (session().screen == Screen::kPause) read_pause_key(event);
}

void SessionWindow::read_pause_key(const InputEvent& event) {
  if (is_press(event, Key::kF1) && fits()) take(ContinueEvent{event.time_ns});
  if (!is_press(event, Key::kF2)) return;
  while (gui_->has_events() && session().screen == Screen::kPause) draw_pause_page();  // of the reason too
  take(AbortEvent{read_reason(pause_), event.time_ns});
}

// Focus, size and monitors: what the experimenter wants to know afterwards.
void SessionWindow::note_changes() {
  for (const WindowChange& change : window_->take_changes()) {
    if (!is_over()) take(NoteEvent{change.kind, change.detail, change.time_ns});
  }
}

bool SessionWindow::is_over() const { return equilux::is_over(session()); }

// Nobody is there to plug in a monitor, or to give the window its size again.
void SessionWindow::check_screen() const {
  if (fits()) return;
  if (window_->has_lost_monitor())
    throw InputError("screen", "", "the monitor on which the session began, " + window_->monitor_name(),
                     "none: it is gone");
  const Size wanted = work_->layout.framebuffer, size = window_->framebuffer();
  throw InputError(
      "screen", "",
      fmt::format("the framebuffer with which the session began, {} x {}", wanted.width, wanted.height),
      fmt::format("{} x {}", size.width, size.height));
}

bool SessionWindow::fits() const {
  return !window_->has_lost_monitor() && window_->framebuffer() == work_->layout.framebuffer;
}

// No picture is scaled, cut off or moved: in a window of another size, or without its monitor, the session
// waits for the experimenter.
void SessionWindow::pause_unless_it_fits() {
  if (fits()) return;
  window_->wait(0);  // what happened is in the log before what follows from it
  note_changes();
  take(PauseEvent{read_clock_ns()});
}

void SessionWindow::draw() {
  pause_unless_it_fits();
  switch (session().screen) {
    case Screen::kTrial:
      if (window_->take_damage()) draw_trial();
      return;
    case Screen::kFeedback:
      return draw_feedback();
    case Screen::kFamiliar:
      return draw_familiar();
    case Screen::kPause:
      return draw_pause_page();
    default:
      return draw_page();
  }
}

void SessionWindow::draw_pair(const std::string& line, bool shows_progress) {
  window_->clear();
  gui_->begin_frame();
  draw_line(*gui_, work_->layout.question, line);
  if (shows_progress) draw_progress(work_->layout, find_progress(session()));
  gui_->end_frame();
  draw_pictures(shown_->pictures, work_->layout);
  window_->swap();
}

void SessionWindow::draw_trial() {
  draw_pair(work_->texts.at("prompt_" + format_experiment(session().experiment)), true);
}

void SessionWindow::draw_feedback() {
  const TrialRow& trial = session().trials.at(static_cast<std::size_t>(*session().last_answered));
  const bool was_right = trial.answer == trial.test_side;
  const char* name = was_right                        ? "feedback_right"
                     : trial.test_side == Side::kLeft ? "feedback_wrong_left"
                                                      : "feedback_wrong_right";
  draw_pair(work_->texts.at(name), false);
}

void SessionWindow::draw_familiar() {
  const int number = session().page;
  const FamiliarPage& page = work_->inputs.familiar_pages.at(static_cast<std::size_t>(number));
  if (!page_ || page_->number != number)
    page_ = LoadedPage{number, load_familiar_pictures(work_->folder(), work_->manifest, page)};
  const Layout& layout = work_->layout;
  const Texts& texts = work_->texts;
  window_->clear();
  gui_->begin_frame();
  if (page.right_key.empty()) {
    draw_line(*gui_, layout.question,
              texts.fill("familiar_object",
                         {{"page", equilux::number(number + 1)},
                          {"pages", equilux::number(count_object_pages(work_->inputs.familiar_pages))}}));
  } else {
    const std::string name = "familiar_" + format_experiment(session().experiment);
    const auto above = [&](const Rectangle& place) {
      return Rectangle{place.x, place.y - kQuestionHeight / 2, place.width, kQuestionHeight / 2};
    };
    draw_line(*gui_, above(layout.left), texts.at(name + "_left"));
    draw_line(*gui_, above(layout.right), texts.at(name + "_right"));
    draw_line(*gui_, {layout.question.x, layout.question.y, layout.question.width, kQuestionHeight / 2},
              texts.at("familiar_turn"));
  }
  gui_->end_frame();
  draw_pictures(page_->pictures, layout);
  window_->swap();
}

void SessionWindow::draw_page() {
  window_->clear();
  gui_->begin_frame();
  const bool is_pressed = lay_out_page();
  gui_->end_frame();
  window_->swap();
  if (is_over()) {
    is_left_ = is_pressed || is_left_;
    return;
  }
  if (session().current < static_cast<int>(session().trials.size())) load_ahead(session().current);
  if (is_pressed) take(ContinueEvent{read_clock_ns()});
}

bool SessionWindow::lay_out_page() {
  const Texts& texts = work_->texts;
  const Size size = window_->framebuffer();
  const std::string count = number(count_main(session(), false)),
                    answered = number(count_main(session(), true));
  switch (session().screen) {
    case Screen::kInstructions:
      return draw_instructions(
          *gui_, size, texts,
          {session().experiment, count_main(session(), false), count_main(session(), true),
           work_->is_set_up ? std::vector<std::string>{} : list_remarks(*work_)});
    case Screen::kPractice:
      return lay_out_message("practice_title",
                             {texts.fill("practice_text", {{"count", number(count_practice(session()))}})},
                             "practice_begin");
    case Screen::kMain:
      return lay_out_message("main_title", {texts.fill("main_text", {{"count", count}})}, "main_begin");
    case Screen::kBreak:
      return lay_out_message(
          "break_title", {texts.fill("break_text", {{"answered", answered}, {"count", count}})}, "break_end");
    default:
      return lay_out_last_page();
  }
}

void SessionWindow::draw_pause_page() {
  window_->clear();
  gui_->begin_frame();
  PauseView view{find_progress(session()), session().paused == Screen::kTrial, work_->layout.framebuffer,
                 describe_way_on(work_->inputs)};
  if (window_->has_lost_monitor()) view.lost_monitor = window_->monitor_name();
  const PauseChoice choice = draw_pause(*gui_, window_->framebuffer(), view, pause_);
  gui_->end_frame();
  window_->swap();
  if (choice == PauseChoice::kGoOn) take(ContinueEvent{read_clock_ns()});
  if (choice == PauseChoice::kEnd) take(AbortEvent{read_reason(pause_), read_clock_ns()});
}

// Title and button by the names of their texts.
bool SessionWindow::lay_out_message(const std::string& title, const std::vector<std::string>& paragraphs,
                                    const std::string& button) const {
  const Texts& texts = work_->texts;
  return draw_message(*gui_, window_->framebuffer(),
                      {texts.at(title), paragraphs, texts.at(button), texts.at("more_below")});
}

bool SessionWindow::lay_out_last_page() const {
  const Texts& texts = work_->texts;
  const bool is_whole = session().screen == Screen::kThanks;
  const std::string your_code = texts.fill("your_code", {{"code", seat_->open.row.participant}});
  std::vector<std::string> paragraphs;
  if (shows_summary_) {
    paragraphs = summarise(session(), work_->inputs.protocol, seat_->notes);
  } else if (is_whole) {
    paragraphs = {texts.at("thanks_text"), your_code, texts.at("thanks_tell")};
  } else {
    paragraphs = {texts.fill("aborted_text", {{"answered", number(count_main(session(), true))},
                                              {"count", number(count_main(session(), false))}}),
                  your_code, texts.at("aborted_tell")};
  }
  return lay_out_message(is_whole ? "thanks_title" : "aborted_title", paragraphs, "close");
}

}  // namespace equilux
