// Dear ImGui as pages of text.
#include "experiment/app/pages.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <imgui.h>
#include <imgui_internal.h>
#include <vector>

namespace equilux {
namespace {

constexpr float kPageWidth = 760;
constexpr float kPageMargin = 24;
constexpr float kPadding = 16;
constexpr float kIndent = 40;
constexpr ImU32 kBlack = IM_COL32(0, 0, 0, 255);
constexpr float kEndless = 1e6F;  // pixels that no line has
constexpr float kLeastText = 12;  // pixels, below which nobody reads

struct BrokenText {
  float size;  ///< of letters, and from line to line; units: pixels
  std::vector<std::string> lines;
};

std::vector<std::string> break_lines(const ImFont& font, float size, const std::string& text, float width) {
  std::vector<std::string> lines;
  const char *begin = text.c_str(), *end = begin + text.size();
  do {
    const char* stop = font.CalcWordWrapPositionA(size / font.FontSize, begin, end, width);
    if (stop == begin && begin != end) ++stop;
    lines.emplace_back(begin, stop);
    for (begin = stop; begin != end && *begin == ' ';) ++begin;
  } while (begin != end);
  return lines;
}

// As large as the place allows, at most the font's own size.
BrokenText fit_text(const ImFont& font, const std::string& text, const Rectangle& place) {
  for (float size = font.FontSize;; size = std::max(kLeastText, std::floor(0.95F * size))) {
    BrokenText broken{size, break_lines(font, size, text, static_cast<float>(place.width))};
    if (size <= kLeastText ||
        size * static_cast<float>(broken.lines.size()) <= static_cast<float>(place.height))
      return broken;
  }
}

// Height of a line below the page, with room above it.
float measure_below(const std::string& text, float width) {
  if (text.empty()) return 0;
  return ImGui::CalcTextSize(text.c_str(), nullptr, false, width).y + kPadding;
}

void write_below(const std::string& text, ImVec2 corner, float width) {
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  list->AddLine(corner, ImVec2(corner.x + width, corner.y), kBlack, 2);
  list->AddText(ImGui::GetFont(), ImGui::GetFontSize(), ImVec2(corner.x, corner.y + kPadding), kBlack,
                text.c_str(), nullptr, width);
}

// At its top, and the frame of the page before is around nothing on a page of text.
void begin_page(PageKind kind) {
  ImGui::SetScrollY(0);
  if (kind == PageKind::kText) ImGui::GetCurrentContext()->NavDisableHighlight = true;
}

}  // namespace

Page::Page(Gui& gui, Size framebuffer, const std::string& title, PageKind kind, const std::string& read_on)
    : gui_(&gui), kind_(kind) {
  const float width =
      std::min(kPageWidth * gui.text_scale(), static_cast<float>(framebuffer.width) - 2 * kPageMargin);
  const float top =
      std::floor(static_cast<float>(framebuffer.height) * (gui.text_scale() > 1 ? 0.05F : 0.14F));
  ImGui::PushFont(gui.text_font());
  const bool goes_on = gui.scroll().at + 1 < gui.scroll().most;
  const float left = std::floor((static_cast<float>(framebuffer.width) - width) / 2);
  const float bottom = static_cast<float>(framebuffer.height) - kPageMargin;
  const float below = gui.scroll().most > 0 ? measure_below(read_on, width) : 0;
  ImGui::SetNextWindowPos(ImVec2(left, top));
  ImGui::SetNextWindowSize(ImVec2(width, bottom - below - top));
  if (const auto target = gui.take_scroll_target()) ImGui::SetNextWindowScroll(ImVec2(-1, *target));
  if (goes_on && below > 0) write_below(read_on, ImVec2(left, bottom - below), width);
  // A window for each title: the keys begin at the first control of a new page.
  ImGui::Begin((title + "##page").c_str(), nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoBackground |
                   ImGuiWindowFlags_NoSavedSettings);
  if (ImGui::IsWindowAppearing()) begin_page(kind);
  ImGui::PushTextWrapPos(0);
  ImGui::PushFont(gui.title_font());
  ImGui::TextUnformatted(title.c_str());
  ImGui::PopFont();
  ImGui::Spacing();
}

Page::~Page() {
  ImGui::PopTextWrapPos();
  gui_->note_scroll({kind_, ImGui::GetScrollY(), ImGui::GetScrollMaxY(), ImGui::GetWindowHeight()});
  ImGui::End();
  ImGui::PopFont();
}

void Page::say(const std::string& paragraph) const { ImGui::TextWrapped("%s", paragraph.c_str()); }

void Page::say_indented(const std::string& paragraph) const {
  ImGui::Indent(kIndent);
  say(paragraph);
  ImGui::Unindent(kIndent);
}

bool Page::press(const std::string& button) const {
  ImGui::Spacing();
  const float room = ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().FramePadding.x;
  return ImGui::Button(break_text(button, room).c_str());
}

void Page::warn(const std::string& text) const {
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

void Page::leave_space() const { ImGui::Spacing(); }

bool Page::is_seen() const {
  const float end = ImGui::GetCursorScreenPos().y - ImGui::GetStyle().ItemSpacing.y;
  return end <= ImGui::GetWindowPos().y + ImGui::GetWindowHeight();
}

std::string break_text(const std::string& text, float width) {
  return fmt::format("{}",
                     fmt::join(break_lines(*ImGui::GetFont(), ImGui::GetFontSize(), text, width), "\n"));
}

FullPage::FullPage(const Gui& gui, Size framebuffer) {
  ImGui::PushFont(gui.text_font());
  ImGui::SetNextWindowPos(ImVec2(kPageMargin, kPageMargin));
  ImGui::SetNextWindowSize(ImVec2(static_cast<float>(framebuffer.width) - 2 * kPageMargin,
                                  static_cast<float>(framebuffer.height) - 2 * kPageMargin));
  ImGui::Begin("full page", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav);
}

FullPage::~FullPage() {
  ImGui::End();
  ImGui::PopFont();
}

void FullPage::say(const std::string& line) const { ImGui::TextWrapped("%s", line.c_str()); }

void draw_line(const Gui& gui, const Rectangle& place, const std::string& text) {
  ImFont* font = gui.text_font();
  const BrokenText broken = fit_text(*font, text, place);
  const float top =
      static_cast<float>(place.y) +
      (static_cast<float>(place.height) - broken.size * static_cast<float>(broken.lines.size())) / 2;
  for (std::size_t i = 0; i < broken.lines.size(); ++i) {
    const std::string& line = broken.lines[i];
    const float width = font->CalcTextSizeA(broken.size, kEndless, 0, line.c_str()).x;
    const ImVec2 corner(
        std::floor(static_cast<float>(place.x) + (static_cast<float>(place.width) - width) / 2),
        std::floor(top + broken.size * static_cast<float>(i)));
    ImGui::GetBackgroundDrawList()->AddText(font, broken.size, corner, kBlack, line.c_str());
  }
}

}  // namespace equilux
