// Pages of text and forms.
#include "experiment/app/screens.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <imgui.h>
#include <utility>

#include "base/error.h"
#include "experiment/app/pages.h"

namespace equilux {
namespace {

constexpr double kMetresPerInch = 0.0254;
constexpr const char* kReadOn = "There is more below (Page Down).";
constexpr float kCardMargin = 24;   // from the edges of the screen; units: pixels
constexpr int kFramesToSettle = 3;  // ImGui knows after two how long a page is

template <std::size_t n>
void copy_text(std::array<char, n>& target, const std::string& text) {
  target.fill('\0');
  std::strncpy(target.data(), text.c_str(), n - 1);
}

template <std::size_t n>
std::string read_text(const std::array<char, n>& field) {
  const std::string text = field.data();
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

struct Limits {
  double least;
  double most;
  const char* unit;
};
constexpr Limits kDiagonal{1, 1000, "inches"}, kDistance{1, 10000, "cm"};

// Empty for what is no number within the limits. Points and commas both separate decimals.
std::optional<double> read_number(std::string text, const Limits& limits) {
  std::replace(text.begin(), text.end(), ',', '.');
  const bool has_letters = text.find_first_not_of("0123456789.") != std::string::npos;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (has_letters || end == text.c_str() || *end != '\0') return std::nullopt;
  if (value < limits.least || value > limits.most) return std::nullopt;
  return value;
}

std::string describe_number_error(const std::string& text, const Limits& limits) {
  if (text.empty() || read_number(text, limits)) return {};
  return fmt::format("Expected a number of {} from {:g} to {:g}, without its unit; got \"{}\".", limits.unit,
                     limits.least, limits.most, text);
}

void draw_field(const char* label, char* text, std::size_t size, bool takes_focus,
                ImGuiInputTextFlags flags = 0) {
  ImGui::TextUnformatted(label);
  ImGui::SetNextItemWidth(-1);
  if (takes_focus) ImGui::SetKeyboardFocusHere();
  ImGui::InputText(fmt::format("##{}", label).c_str(), text, size, flags);
}

// Options one beside the other, as many in a line as have room there.
class Options {
 public:
  explicit Options(float between) : between_(between) {
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(4, 3));
  }
  ~Options() { ImGui::PopStyleVar(); }
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;

  // True when it was pressed.
  bool draw(const std::string& label, bool is_chosen) {
    const float line = ImGui::GetContentRegionAvail().x;
    const float circle = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemInnerSpacing.x;
    const std::string lines = break_text(label, line - circle);
    const float width = circle + ImGui::CalcTextSize(lines.c_str()).x;
    const bool has_room = room_ >= between_ + width;
    if (has_room) ImGui::SameLine(0, between_);
    room_ = (has_room ? room_ - between_ : line) - width;
    return ImGui::RadioButton(lines.c_str(), is_chosen);
  }

 private:
  float between_;  // units: pixels
  float room_ = 0;
};

void draw_choice(int& experiment) {
  ImGui::TextUnformatted("Experiment");
  Options options(40);
  if (options.draw("Artifacts (F1)", experiment == 0)) experiment = 0;
  if (options.draw("Material (F2)", experiment == 1)) experiment = 1;
}

std::string describe_setup(const SetupView& view) {
  const ScreenFacts& facts = *view.facts;
  std::string text = fmt::format(
      "Monitor {}: {} x {} pixels at {:.0f} Hz, measured {}. Framebuffer {} x {} (the pictures need {} x "
      "{}). Gamma "
      "ramp {}, colour profile {}.",
      facts.monitor, facts.mode.width, facts.mode.height, facts.mode_hz,
      facts.measured_hz ? fmt::format("{:.1f} Hz", *facts.measured_hz) : "nothing", facts.framebuffer.width,
      facts.framebuffer.height, view.least_framebuffer.width, view.least_framebuffer.height, facts.gamma_ramp,
      facts.icc_profile);
  return text;
}

// Nothing where there is no choice.
void draw_monitors(const SetupView& view, SetupForm& form) {
  if (find_next_monitor(view.monitors, view.facts->monitor).empty()) return;
  ImGui::TextUnformatted("Everything is shown on (F5: on the next one)");
  Options options(40);
  for (const std::string& name : view.monitors) {
    if (options.draw(name, name == view.facts->monitor)) form.wanted_monitor = name;
  }
}

std::string describe_degrees(const ViewingSetup& setup) {
  if (!setup.degrees) return "The size of a pixel is not known yet.";
  return fmt::format(
      "At {:.1f} cm ({}) a picture spans {:.2f} x {:.2f} degrees; a pixel is {:.4f} mm wide (by the {}).",
      100 * setup.viewing_distance_m,
      setup.distance_source == kTypedDistance ? "typed" : "assumed: the study's", setup.degrees->wide,
      setup.degrees->high, 1000 * setup.pitch->x_m, setup.pitch_source);
}

// A bar as wide as a card, to be compared with a real one; on a fine screen wider than the page.
void draw_card(int card_px) {
  constexpr float kHeight = 36;
  const auto width = static_cast<float>(card_px);
  const float right = ImGui::GetIO().DisplaySize.x - kCardMargin, from = ImGui::GetCursorScreenPos().x;
  const ImVec2 corner(std::max(kCardMargin, std::min(from, right - width)), ImGui::GetCursorScreenPos().y);
  const ImVec2 end(corner.x + width, corner.y + kHeight), top = ImGui::GetWindowPos();
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  list->PushClipRect(ImVec2(0, top.y), ImVec2(right + kCardMargin, top.y + ImGui::GetWindowHeight()));
  list->AddRectFilled(corner, end, IM_COL32(240, 240, 240, 255));
  list->AddRect(corner, end, IM_COL32(0, 0, 0, 255));
  list->PopClipRect();
  ImGui::Dummy(ImVec2(0, kHeight));
}

void draw_card_form(SetupForm& form) {
  constexpr int kLeast = 40;
  ImGui::TextWrapped(
      "Hold a bank card to the bar and change the bar until it is as wide as the card's long side.");
  bool holds = form.card_px > 0;
  const float room =
      ImGui::GetContentRegionAvail().x - ImGui::GetFrameHeight() - ImGui::GetStyle().ItemInnerSpacing.x;
  if (ImGui::Checkbox(break_text("a card is held to the screen (F3)", room).c_str(), &holds))
    switch_card(form);
  if (form.card_px == 0) return;
  const int most = std::max(kLeast + 1, static_cast<int>(ImGui::GetIO().DisplaySize.x - 2 * kCardMargin));
  ImGui::SetNextItemWidth(-1);
  form.was_card_matched |= ImGui::SliderInt("##card", &form.card_px, kLeast, most, "%d pixels");
  const bool fits = form.card_px > kLeast && form.card_px < most;
  form.card_px = std::clamp(form.card_px, kLeast, most);
  form.was_card_matched &= fits;
  draw_card(form.card_px);
  if (!fits) {
    ImGui::TextWrapped("The bar goes from %d to %d pixels: at an end of these the card does not count.",
                       kLeast, most);
  } else if (!form.was_card_matched) {
    ImGui::TextWrapped("The bar was not changed yet: the card does not count.");
  }
}

void draw_radio(const Texts& texts, const SessionProtocol& protocol, Intake& intake,
                const AskedQuestion& asked) {
  const std::string name = format_question(asked.question);
  ImGui::TextWrapped("%s %s", texts.at(name).c_str(), asked.required ? "" : texts.at("optional").c_str());
  ImGui::PushID(name.c_str());
  const auto current = intake.answers.find(asked.question);
  const std::string chosen = current == intake.answers.end() ? "" : current->second;
  Options options(24);
  for (const std::string& choice : enumerate_choices(asked.question)) {
    if (options.draw(texts.at(name + "." + choice), chosen == choice))
      choose_answer(intake, protocol, asked.question, chosen == choice ? "" : choice);
  }
  ImGui::PopID();
  ImGui::Spacing();
}

}  // namespace

StartForm make_start_form(const AppParams& params) {
  StartForm form;
  copy_text(form.folder, params.study_folder.string());
  copy_text(form.participant, params.participant);
  if (params.experiment) set_experiment(form, *params.experiment);
  return form;
}

AppParams read_start_form(const StartForm& form, const AppParams& params) {
  AppParams chosen = params;
  chosen.study_folder = read_text(form.folder);
  chosen.participant = read_text(form.participant);
  if (chosen.study_folder.empty()) throw InputError("Study folder", "", "a path", "nothing");
  if (form.experiment < 0) throw InputError("Experiment", "", "one of the two", "none");
  if (chosen.participant.empty()) throw InputError("Participant code", "", "a code", "nothing");
  chosen.experiment = form.experiment == 0 ? Experiment::kArtifact : Experiment::kMaterial;
  return chosen;
}

std::string read_folder(const StartForm& form) { return read_text(form.folder); }

void set_participant(StartForm& form, const std::string& code) { copy_text(form.participant, code); }

void set_experiment(StartForm& form, Experiment experiment) {
  form.experiment = experiment == Experiment::kArtifact ? 0 : 1;
}

bool draw_start(Gui& gui, Size framebuffer, StartForm& form) {
  const Page page(gui, framebuffer, "New session", PageKind::kForm, kReadOn);
  const bool takes_focus = std::exchange(form.takes_focus, false);
  const bool is_code_next = form.folder[0] != '\0' && form.participant[0] == '\0';
  draw_field("Study folder", form.folder.data(), form.folder.size(), takes_focus && !is_code_next);
  draw_choice(form.experiment);
  draw_field("Participant code (not a name; F3 draws a new one, F4 takes the one that was interrupted last)",
             form.participant.data(), form.participant.size(), takes_focus && is_code_next);
  const bool is_pressed = page.press("Start (Enter)");
  if (!form.error.empty()) {
    page.leave_space();
    page.warn("Cannot start. " + form.error);
  }
  return is_pressed;
}

SetupForm make_setup_form(double diagonal_m, double viewing_distance_m) {
  SetupForm form;
  if (diagonal_m > 0) copy_text(form.diagonal_inches, fmt::format("{:g}", diagonal_m / kMetresPerInch));
  if (viewing_distance_m > 0) copy_text(form.distance_cm, fmt::format("{:g}", 100 * viewing_distance_m));
  return form;
}

SetupErrors find_errors(const SetupForm& form) {
  return {describe_number_error(read_text(form.diagonal_inches), kDiagonal),
          describe_number_error(read_text(form.distance_cm), kDistance)};
}

bool is_right(const SetupForm& form) {
  const SetupErrors errors = find_errors(form);
  return errors.diagonal.empty() && errors.distance.empty();
}

std::string find_next_monitor(const std::vector<std::string>& names, const std::string& used) {
  const auto found = std::find(names.begin(), names.end(), used);
  if (found == names.end()) return names.empty() ? "" : names.front();
  const std::string& next = std::next(found) == names.end() ? names.front() : *std::next(found);
  return next == used ? "" : next;
}

void forget_monitor(SetupForm& form) {
  form.diagonal_inches.fill('\0');
  form.card_px = 0;
  form.was_card_matched = false;
}

void switch_card(SetupForm& form) {
  constexpr int kFirstPx = 320;
  form.card_px = form.card_px > 0 ? 0 : kFirstPx;
  form.was_card_matched = false;
}

SetupInput read_setup_form(const SetupForm& form) {
  return {read_number(read_text(form.diagonal_inches), kDiagonal).value_or(0) * kMetresPerInch,
          form.was_card_matched ? form.card_px : 0,
          read_number(read_text(form.distance_cm), kDistance).value_or(0) / 100};
}

bool leave_setup(SetupForm& form) {
  form.takes_focus = !is_right(form);
  return !form.takes_focus;
}

bool draw_setup(Gui& gui, Size framebuffer, const SetupView& view, SetupForm& form) {
  const Page page(gui, framebuffer, "Set-up, for the experimenter", PageKind::kForm, kReadOn);
  page.say(fmt::format("Participant {}, {} experiment. {} Escape, held for two seconds, leaves without it.",
                       view.participant, view.experiment,
                       view.goes_on_with.empty() ? "A new session." : view.goes_on_with));
  if (!view.clock.empty()) page.warn(view.clock);
  page.say(describe_setup(view));
  draw_monitors(view, form);
  if (!form.error.empty()) page.warn(form.error);
  const SetupErrors errors = find_errors(form);
  const bool takes_focus = std::exchange(form.takes_focus, false);
  draw_field("Diagonal of the visible screen, in inches", form.diagonal_inches.data(),
             form.diagonal_inches.size(), takes_focus && !errors.diagonal.empty(),
             ImGuiInputTextFlags_AutoSelectAll);
  if (!errors.diagonal.empty()) page.warn(errors.diagonal);
  draw_field(
      fmt::format("Distance from the eyes to the screen, in cm (left empty, the study's {:g} is assumed)",
                  100 * view.target_distance_m)
          .c_str(),
      form.distance_cm.data(), form.distance_cm.size(), takes_focus && errors.diagonal.empty(),
      ImGuiInputTextFlags_AutoSelectAll);
  if (!errors.distance.empty()) page.warn(errors.distance);
  draw_card_form(form);
  page.say(describe_degrees(*view.setup));
  const bool is_pressed = page.press("Continue (Enter)");
  page.leave_space();
  for (const std::string& remark : view.setup->remarks) page.warn(remark);
  return is_pressed && leave_setup(form);
}

std::optional<bool> take_choice(const ConsentForm& form, bool agrees) {
  if (agrees && !form.is_read) return std::nullopt;
  return agrees;
}

std::optional<bool> find_choice(const ConsentForm& form, Key key) {
  if (key == Key::kEnter) return take_choice(form, form.focused.value_or(true));
  if (key == Key::kBackspace) return false;
  return std::nullopt;
}

std::optional<bool> draw_consent(Gui& gui, Size framebuffer, const Texts& texts, const Consent& consent,
                                 ConsentForm& form) {
  const Page page(gui, framebuffer, texts.at("consent_title"), PageKind::kText,
                  texts.at(form.is_read ? "more_below" : "consent_read_on"));
  for (const std::string& paragraph : consent.text) page.say(paragraph);
  page.say(fmt::format("({})", consent.version));
  form.is_read = form.is_read || (++form.frames > kFramesToSettle && page.is_seen());
  std::optional<bool> choice;
  form.focused.reset();
  for (const bool agrees : {true, false}) {
    if (page.press(texts.at(agrees ? "consent_agree" : "consent_decline")))
      choice = take_choice(form, agrees);
    if (gui.has_frame()) form.focused = agrees;
  }
  return choice;
}

bool draw_questions(Gui& gui, Size framebuffer, const Texts& texts, const SessionProtocol& protocol,
                    Intake& intake, bool is_reminded) {
  const Page page(gui, framebuffer, texts.at("questions_title"), PageKind::kForm, texts.at("more_below"));
  page.say(texts.at("questions_about"));
  page.leave_space();
  for (const AskedQuestion& asked : protocol.questions) draw_radio(texts, protocol, intake, asked);
  const bool is_pressed = page.press(texts.at("questions_continue"));
  bool& was_reminded = *ImGui::GetStateStorage()->GetBoolRef(ImGui::GetID("reminded"));
  const bool reminds = is_reminded && !find_unanswered(intake, protocol).empty();
  if (reminds) page.warn(texts.at("questions_missing"));
  if (reminds && !was_reminded) ImGui::SetScrollHereY(1);  // once, where the page is longer than the screen
  was_reminded = reminds;
  return is_pressed;
}

bool draw_instructions(Gui& gui, Size framebuffer, const Texts& texts, const InstructionsText& text) {
  const std::string name = format_experiment(text.experiment);
  const Page page(gui, framebuffer, texts.at("instructions_title"), PageKind::kText, texts.at("more_below"));
  page.say(texts.at("instructions_" + name));
  page.say(texts.at("instructions_" + name + "_question"));
  page.say_indented(texts.at("prompt_" + name));
  page.say(texts.at("instructions_answer_" + name));
  page.say(texts.at("instructions_time"));
  page.say(texts.at("instructions_stop"));
  const std::string count = fmt::format("{}", text.trial_count), answered = fmt::format("{}", text.answered);
  page.say(text.answered > 0 ? texts.fill("instructions_resumed", {{"answered", answered}, {"count", count}})
                             : texts.fill("instructions_count", {{"count", count}}));
  const bool is_pressed = page.press(texts.at("instructions_begin"));
  page.leave_space();
  for (const std::string& remark : text.remarks) page.warn("For the experimenter: " + remark);
  return is_pressed;
}

void draw_progress(const Layout& layout, const TrialProgress& progress) {
  constexpr float kWidth = 200, kHeight = 2, kBelow = 12;
  if (progress.count == 0) return;
  const Rectangle& place = layout.question;
  const float left = std::floor(static_cast<float>(place.x) + (static_cast<float>(place.width) - kWidth) / 2);
  const float top = static_cast<float>(place.y + place.height) - kBelow;
  const float full =
      std::round(kWidth * static_cast<float>(progress.answered) / static_cast<float>(progress.count));
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  list->AddRectFilled(ImVec2(left, top), ImVec2(left + kWidth, top + kHeight), IM_COL32(112, 112, 112, 255));
  list->AddRectFilled(ImVec2(left, top), ImVec2(left + full, top + kHeight), IM_COL32(64, 64, 64, 255));
}

bool draw_message(Gui& gui, Size framebuffer, const MessageText& text) {
  const Page page(gui, framebuffer, text.title, PageKind::kText, text.read_on);
  for (const std::string& paragraph : text.paragraphs) page.say(paragraph);
  return page.press(text.button);
}

std::string describe_misfit(Size framebuffer, Size wanted, const std::string& way_on) {
  return fmt::format(
      "The screen or window is now {} x {} pixels; this sitting began with {} x {}. Pictures are "
      "never scaled, cut off or moved: give it that size again (video mode, monitor, window manager), "
      "and the session can go on here. If the window is closed, {}. What was answered is kept.",
      framebuffer.width, framebuffer.height, wanted.width, wanted.height, way_on);
}

std::string describe_lost_monitor(const std::string& monitor, const std::string& way_on) {
  return fmt::format(
      "The session's monitor, {}, is gone: unplugged, switched off, or taken out of the desktop. Nothing "
      "that is pressed counts as an answer meanwhile. Connect it again, and the session can go on there; or "
      "end it here. On another monitor pictures would have another size: if this one does not come back, "
      "close the window (Alt-F4): {}. What was answered is kept.",
      monitor, way_on);
}

std::string read_reason(const PauseForm& form) {
  const std::string reason = read_text(form.reason);
  return reason.empty() ? "ended by the experimenter" : reason;
}

std::string describe_pause(const PauseView& view) {
  return fmt::format(
      "{} of {} answers of this part are recorded. The {} that was on the screen is shown again.",
      view.progress.answered, view.progress.count, view.shows_pair_again ? "pair" : "page");
}

PauseChoice draw_pause(Gui& gui, Size framebuffer, const PauseView& view, PauseForm& form) {
  const Page page(gui, framebuffer, "Paused, for the experimenter", PageKind::kForm, kReadOn);
  page.say(describe_pause(view));
  if (view.lost_monitor) {
    page.warn(describe_lost_monitor(*view.lost_monitor, view.way_on));
  } else if (framebuffer != view.wanted) {
    page.warn(describe_misfit(framebuffer, view.wanted, view.way_on));
  } else if (page.press("Go on (F1)")) {
    return PauseChoice::kGoOn;
  }
  page.leave_space();
  draw_field("Reason, if the session is to end here", form.reason.data(), form.reason.size(), false);
  if (page.press("End the session (F2)")) return PauseChoice::kEnd;
  page.say("An ended session can go on later, with the same participant code, where the protocol allows it.");
  return PauseChoice::kNone;
}

}  // namespace equilux
