// The graphs of the report, drawn by Dear ImGui: the same regions, letters, dots and words.
#include "experiment/app/results_view.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <imgui.h>
#include <utility>

#include "base/error.h"
#include "experiment/app/pages.h"

namespace equilux {
namespace {

// At the browser's usual size of text, with which they grow.
constexpr float kUsualText = 17.6F;
constexpr float kCellWidth = 40, kCellHeight = 18, kAxis = 34, kHead = 24, kFoot = 46, kGap = 14;
constexpr float kScroll = 80;
constexpr float kDot = 3.5F, kSmall = 15, kDotInset = 6;
constexpr ImU32 kInk = IM_COL32(0, 0, 0, 255), kPaper = IM_COL32(255, 255, 255, 255);

float scaled(float pixels) { return pixels * ImGui::GetFontSize() / kUsualText; }

struct Look {
  std::array<int, 3> fill;
  const char* letter;
};

Look look_of(Region region) {
  switch (region) {
    case Region::kArtifact:
      return {{247, 188, 201}, "A"};
    case Region::kChanged:
      return {{224, 96, 79}, "M"};
    case Region::kBoth:
      return {{236, 143, 147}, "AM"};
    case Region::kEquivalent:
      return {{147, 207, 152}, "E"};
    case Region::kUntested:
      break;
  }
  return {{241, 241, 239}, "?"};
}

// Paler where it is inferred, as in the report's graphs.
ImU32 fill_of(const Look& look, bool is_observed) {
  const auto pale = [&](int value) { return is_observed ? value : (55 * value + 45 * 255) / 100; };
  return IM_COL32(pale(look.fill[0]), pale(look.fill[1]), pale(look.fill[2]), 255);
}

const char* mark_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kExists:
      return "EE";
    case Verdict::kNone:
      return "no";
    case Verdict::kUntested:
      break;
  }
  return "?";
}

template <typename T>
void add_once(std::vector<T>& values, const T& value) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

std::string describe(const SessionCounts& counts) {
  return fmt::format("{} finished{}", counts.finished,
                     counts.unfinished > 0 ? fmt::format(", {} not", counts.unfinished) : "");
}

void write_centred(ImDrawList* list, float x, float y, const char* text) {
  const ImVec2 size = ImGui::GetFont()->CalcTextSizeA(scaled(kSmall), 1e6F, 0, text);
  list->AddText(nullptr, scaled(kSmall), ImVec2(x - size.x / 2, y), kInk, text);
}

// Filled where flagged, open where not; nothing where untested.
void draw_dot(ImDrawList* list, ImVec2 place, const Count& count) {
  if (count.n == 0) return;
  list->AddCircleFilled(place, scaled(kDot), is_flagged(count) ? kInk : kPaper);
  list->AddCircle(place, scaled(kDot), kInk);
}

void draw_level(ImDrawList* list, ImVec2 corner, const ColumnFinding& column, const RuleFinding& finding,
                std::size_t level) {
  const ImVec2 end(corner.x + scaled(kCellWidth) - 1, corner.y + scaled(kCellHeight) - 1);
  const Look look = look_of(finding.regions[level]);
  list->AddRectFilled(corner, end, fill_of(look, is_observed(column, finding.regions[level], level)));
  const float middle = corner.x + scaled(kCellWidth) / 2, dot_y = corner.y + scaled(kCellHeight) / 2;
  write_centred(list, middle, corner.y + 1, look.letter);
  draw_dot(list, ImVec2(corner.x + scaled(kDotInset), dot_y), column.artifact[level].count);
  draw_dot(list, ImVec2(end.x - scaled(kDotInset), dot_y), column.material[level].count);
  const int name = column.artifact[level].level;
  if (std::find(finding.supported.begin(), finding.supported.end(), name) != finding.supported.end())
    list->AddLine(ImVec2(middle - 6, end.y - 2), ImVec2(middle + 6, end.y - 2), kInk, 1.5F);
}

// From no clamp at the bottom to the hardest at the top, from few to many VPLs.
void draw_graph(ImDrawList* list, ImVec2 corner, const std::vector<const ColumnFinding*>& columns,
                Rule rule) {
  const std::size_t levels = columns.front()->artifact.size();
  const float top = corner.y + scaled(kHead), height = scaled(kCellHeight) * static_cast<float>(levels);
  list->AddText(corner, kInk, format_key(columns.front()->column.object).c_str());
  for (std::size_t i = 0; i < levels; ++i) {
    const float y = top + height - scaled(kCellHeight) * static_cast<float>(i + 1);
    list->AddText(nullptr, scaled(kSmall), ImVec2(corner.x, y + 1), kInk,
                  format_clamp(columns.front()->artifact[i].level).c_str());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      draw_level(list, ImVec2(corner.x + scaled(kAxis) + scaled(kCellWidth) * static_cast<float>(c), y),
                 *columns[c], columns[c]->under(rule), i);
    }
  }
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const float x = corner.x + scaled(kAxis) + scaled(kCellWidth) * (static_cast<float>(c) + 0.5F);
    write_centred(list, x, top + height + 2, format_vpl_count(columns[c]->column.vpl_count).c_str());
    write_centred(list, x, top + height + 2 + scaled(kSmall), mark_of(columns[c]->under(rule).verdict));
  }
}

}  // namespace

ResultsView::ResultsView(StudyFolder folder, Study study)
    : folder_(std::move(folder)), study_(std::move(study)) {
  for (const Object& object : enumerate_objects(study_)) {
    add_once(geometries_, object.geometry);
    add_once(materials_, object.material);
    add_once(illuminations_, object.illumination);
  }
}

void ResultsView::read(SubjectKind kind) {
  kind_ = kind;
  message_.clear();
  try {
    interim_ = load_interim(folder_, study_, kind);
  } catch (const std::exception& error) {
    interim_ = {};
    message_ = error.what();
  }
}

bool ResultsView::press(int code) {
  switch (code) {
    case GLFW_KEY_U:
      rule_ = rule_ == Rule::kPaper ? Rule::kIsotonic : Rule::kPaper;
      return true;
    case GLFW_KEY_PAGE_UP:
    case GLFW_KEY_PAGE_DOWN:
      illumination_ = (illumination_ + 1) % illuminations_.size();
      return true;
    case GLFW_KEY_UP:
      scroll_y_ -= kScroll;
      return true;
    case GLFW_KEY_DOWN:
      scroll_y_ += kScroll;
      return true;
    case GLFW_KEY_LEFT:
      scroll_x_ -= kScroll;
      return true;
    case GLFW_KEY_RIGHT:
      scroll_x_ += kScroll;
      return true;
    default:
      return false;
  }
}

std::vector<std::string> ResultsView::list_lines() const {
  const bool is_person = kind_ == SubjectKind::kPerson;
  std::vector<std::string> lines{
      fmt::format(
          "{}, {}: what the {} subjects answered so far. Artifact sessions: {}; material sessions: {}. "
          "Only finished ones count.",
          study_.name, format_illumination(illuminations_[illumination_]), format_kind(kind_),
          describe(interim_.artifact), describe(interim_.material)),
      fmt::format("Rule {} (U: the other one). K: {} subjects. F5 reads anew; arrows scroll.{} G or "
                  "Backspace: back to the "
                  "pictures.",
                  format_rule(rule_), is_person ? "planted" : "person",
                  illuminations_.size() > 1 ? " PageUp, PageDown: the other light." : ""),
      "A artifacts seen, M material changed, AM both, E visually equivalent (underlined: supported at 95 %), "
      "? "
      "not tested enough; paler: inferred by the rule, not tested. Dots: artifact left, material right, "
      "filled where "
      "3/4 or more were right."};
  if (!message_.empty()) lines.push_back(message_);
  return lines;
}

std::vector<const ColumnFinding*> ResultsView::columns_of(const std::string& geometry,
                                                          const std::string& material) const {
  const Object object{geometry, material, illuminations_[illumination_]};
  std::vector<const ColumnFinding*> columns;
  for (const ColumnFinding& column : interim_.columns) {
    if (column.column.object == object) columns.push_back(&column);
  }
  std::sort(columns.begin(), columns.end(),
            [](const auto* a, const auto* b) { return a->column.vpl_count < b->column.vpl_count; });
  return columns;
}

void ResultsView::draw_table() const {
  if (!ImGui::BeginTable(
          "ee", static_cast<int>(materials_.size()) + 1,
          ImGuiTableFlags_Borders | ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoHostExtendX))
    return;
  ImGui::TableNextColumn();
  ImGui::TextUnformatted("EE");
  for (const std::string& material : materials_) {
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(material.c_str());
  }
  for (const std::string& geometry : geometries_) {
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(geometry.c_str());
    for (const std::string& material : materials_) {
      std::vector<std::string> marks;
      for (const ColumnFinding* column : columns_of(geometry, material))
        marks.push_back(fmt::format("{} {}", format_vpl_count(column->column.vpl_count),
                                    mark_of(column->under(rule_).verdict)));
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(fmt::format("{}", fmt::join(marks, "   ")).c_str());
    }
  }
  ImGui::EndTable();
}

void ResultsView::draw_graphs() const {
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  float y = origin.y, right = origin.x;
  for (const std::string& geometry : geometries_) {
    float x = origin.x, below = y;
    for (const std::string& material : materials_) {
      const auto columns = columns_of(geometry, material);
      if (columns.empty()) continue;
      draw_graph(ImGui::GetWindowDrawList(), ImVec2(x, y), columns, rule_);
      x += scaled(kAxis) + scaled(kCellWidth) * static_cast<float>(columns.size()) + scaled(kGap);
      below = std::max(below, y + scaled(kHead) +
                                  scaled(kCellHeight) * static_cast<float>(columns.front()->artifact.size()) +
                                  scaled(kFoot));
    }
    right = std::max(right, x);
    y = below;
  }
  ImGui::Dummy(ImVec2(right - origin.x, y - origin.y));
}

void ResultsView::draw(AppWindow& window, const Gui& gui) {
  const FullPage page(gui, window.framebuffer());
  for (const std::string& line : list_lines()) page.say(line);
  ImGui::BeginChild(
      "graphs", ImVec2(0, 0), false,
      ImGuiWindowFlags_NoBackground | ImGuiWindowFlags_HorizontalScrollbar | ImGuiWindowFlags_NoNav);
  ImGui::SetScrollX(ImGui::GetScrollX() + std::exchange(scroll_x_, 0.0F));
  ImGui::SetScrollY(ImGui::GetScrollY() + std::exchange(scroll_y_, 0.0F));
  draw_table();
  ImGui::Dummy(ImVec2(0, scaled(kGap)));
  draw_graphs();
  ImGui::EndChild();
}

}  // namespace equilux
