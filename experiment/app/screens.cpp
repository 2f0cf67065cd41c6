// Pages of text and forms.
#include "experiment/app/screens.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <imgui.h>
#include <utility>

#include "base/error.h"

namespace equilux {
namespace {

constexpr float kPageWidth = 760;
constexpr float kPageMargin = 24;
constexpr ImU32 kBlack = IM_COL32(0, 0, 0, 255);

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

// A column of text in the middle of the screen; it scrolls where it does not fit.
class Page {
 public:
  Page(const Gui& gui, Size framebuffer, const std::string& title) {
    const float width = std::min(kPageWidth, static_cast<float>(framebuffer.width) - 2 * kPageMargin);
    const float top = std::floor(static_cast<float>(framebuffer.height) * 0.14F);
    ImGui::PushFont(gui.text_font());
    ImGui::SetNextWindowPos(ImVec2(std::floor((static_cast<float>(framebuffer.width) - width) / 2), top));
    ImGui::SetNextWindowSize(ImVec2(width, static_cast<float>(framebuffer.height) - top - kPageMargin));
    ImGui::Begin("page", nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                     ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBackground |
                     ImGuiWindowFlags_NoSavedSettings);
    ImGui::PushTextWrapPos(0);
    ImGui::PushFont(gui.title_font());
    ImGui::TextUnformatted(title.c_str());
    ImGui::PopFont();
    ImGui::Spacing();
  }
  ~Page() {
    ImGui::PopTextWrapPos();
    ImGui::End();
    ImGui::PopFont();
  }
  Page(const Page&) = delete;
  Page& operator=(const Page&) = delete;

  void say(const std::string& paragraph) const { ImGui::TextWrapped("%s", paragraph.c_str()); }
  bool press(const std::string& button) const {
    ImGui::Spacing();
    return ImGui::Button(button.c_str());
  }
};

// A pale panel, for what must not be overlooked.
void draw_panel(const std::string& text) {
  constexpr float kPadding = 16;
  const float width = ImGui::GetContentRegionAvail().x;
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, width - 2 * kPadding);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 end(corner.x + width, corner.y + size.y + 2 * kPadding);
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(corner, end, IM_COL32(232, 232, 232, 255), 3);
  list->AddRectFilled(corner, ImVec2(corner.x + 6, end.y), IM_COL32(150, 0, 0, 255));
  list->AddText(nullptr, 0, ImVec2(corner.x + kPadding, corner.y + kPadding), kBlack, text.c_str(), nullptr,
                width - 2 * kPadding);
  ImGui::Dummy(ImVec2(width, end.y - corner.y));
}

void draw_field(const char* label, char* text, std::size_t size, bool takes_focus) {
  ImGui::TextUnformatted(label);
  ImGui::SetNextItemWidth(-1);
  if (takes_focus) ImGui::SetKeyboardFocusHere();
  ImGui::InputText(fmt::format("##{}", label).c_str(), text, size);
}

void draw_choice(int& experiment) {
  ImGui::TextUnformatted("Experiment");
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(4, 3));
  ImGui::RadioButton("Artifacts (F1)", &experiment, 0);
  ImGui::SameLine(0, 40);
  ImGui::RadioButton("Material (F2)", &experiment, 1);
  ImGui::PopStyleVar();
}

std::vector<std::string> list_instructions(Experiment experiment) {
  if (experiment == Experiment::kArtifact) {
    return {
        "You will see pairs of pictures of an object in a room. In one of the two, the image of the object "
        "has artifacts: flaws of the image, such as bright spots or edges of light and shadow that do not "
        "belong there. The two objects are of different materials and are seen from different sides; that "
        "does not matter.",
        "For each pair the question is:"};
  }
  return {
      "You will see three pictures of an object in a room. The upper one is the reference. In one of the two "
      "lower pictures the object looks as if it were made of another material than in the reference. The "
      "object may be seen from another side; that does not matter.",
      "Each time the question is:"};
}

}  // namespace

StartForm make_start_form(const AppParams& params) {
  StartForm form;
  copy_text(form.folder, params.study_folder.string());
  copy_text(form.participant, params.participant);
  if (params.experiment) form.experiment = *params.experiment == Experiment::kArtifact ? 0 : 1;
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

bool draw_start(const Gui& gui, Size framebuffer, StartForm& form) {
  const Page page(gui, framebuffer, "New session");
  const bool takes_focus = std::exchange(form.takes_focus, false);
  const bool is_code_next = form.folder[0] != '\0' && form.participant[0] == '\0';
  draw_field("Study folder", form.folder.data(), form.folder.size(), takes_focus && !is_code_next);
  draw_choice(form.experiment);
  draw_field("Participant code (not a name)", form.participant.data(), form.participant.size(),
             takes_focus && is_code_next);
  const bool is_pressed = page.press("Start (Enter)");
  if (!form.error.empty()) {
    ImGui::Spacing();
    draw_panel("Cannot start. " + form.error);
  }
  return is_pressed;
}

bool draw_instructions(const Gui& gui, Size framebuffer, const InstructionsText& text) {
  const Page page(gui, framebuffer, "Instructions");
  for (const std::string& paragraph : list_instructions(text.experiment)) page.say(paragraph);
  ImGui::Indent(40);
  page.say(prompt_of(text.experiment));
  ImGui::Unindent(40);
  page.say(fmt::format(
      "Answer by clicking on one of the two {}pictures, or with the keys ← for the left and → for "
      "the right one.",
      text.experiment == Experiment::kMaterial ? "lower " : ""));
  page.say(
      "There is no time limit. Where you are not sure, choose the one that seems more likely. An answer "
      "cannot be taken back.");
  page.say(
      "You may stop at any time: call the experimenter, who ends the session by holding Escape for two "
      "seconds.");
  page.say(text.answered > 0 ? fmt::format("This session goes on where it stopped, after {} of {} answers.",
                                           text.answered, text.trial_count)
                             : fmt::format("There are {} questions.", text.trial_count));
  const bool is_pressed = page.press("Begin (Space)");
  ImGui::Spacing();
  for (const std::string& remark : text.remarks) draw_panel("For the experimenter: " + remark);
  return is_pressed;
}

void draw_question(const Gui& gui, const Layout& layout, Experiment experiment) {
  const std::string prompt = prompt_of(experiment);
  ImFont* font = gui.text_font();
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e6F, 0, prompt.c_str());
  const Rectangle& place = layout.question;
  const ImVec2 corner(
      std::floor(static_cast<float>(place.x) + (static_cast<float>(place.width) - size.x) / 2),
      std::floor(static_cast<float>(place.y) + (static_cast<float>(place.height) - size.y) / 2));
  ImGui::GetBackgroundDrawList()->AddText(font, font->FontSize, corner, kBlack, prompt.c_str());
}

bool draw_message(const Gui& gui, Size framebuffer, const std::string& title,
                  const std::vector<std::string>& paragraphs, const std::string& button) {
  const Page page(gui, framebuffer, title);
  for (const std::string& paragraph : paragraphs) page.say(paragraph);
  return page.press(button);
}

}  // namespace equilux
