// Findings to SVG. The numbers in this file are pixels of the picture and nothing else.
#include "analysis/graph.h"

#include <algorithm>

#include "analysis/markup.h"
#include "analysis/tables.h"
#include "analysis/tally.h"
#include "base/error.h"

namespace equilux {
namespace {

constexpr int kLeft = 30;
constexpr int kTop = 22;
constexpr int kBottom = 30;
constexpr int kRight = 4;
constexpr int kCellWidth = 46;
constexpr int kCellHeight = 15;
constexpr int kLoneWidth = 290;  // at least, for the words of a graph in a file of its own
constexpr int kLine = 12;        // height of a line of these
constexpr double kLetter = 4.7;  // width of a letter of them, on average
constexpr const char* kInk = "#1c1c1c";

struct Look {
  const char* name;   // of the hatch
  const char* fill;   // background
  const char* hatch;  // path data in a tile of 6 x 6; empty for none
  const char* ink;    // of the hatch
  const char* letter;
};

Look look_of(Region region) {
  switch (region) {
    case Region::kArtifact:
      return {"artifact", "#f7bcc9", "M-1,1 l2,-2 M0,6 l6,-6 M5,7 l2,-2", "#d97f97", "A"};
    case Region::kChanged:
      return {"changed", "#e0604f", "M-1,5 l2,2 M0,0 l6,6 M5,-1 l2,2", "#b53b2c", "M"};
    case Region::kBoth:
      return {"both", "#ec8f93", "M0,6 l6,-6 M0,0 l6,6", "#c25560", "AM"};
    case Region::kEquivalent:
      return {"equivalent", "#93cf98", "", "", "E"};
    case Region::kUntested:
      break;
  }
  return {"untested", "#f1f1ef", "M3,2.5 v1", "#8d8d88", "?"};
}

std::string draw_hatch(const std::string& prefix, Region region) {
  const Look look = look_of(region);
  std::string text = fmt::format(
      R"(<pattern id="{}-{}" width="6" height="6" patternUnits="userSpaceOnUse"><rect width="6" height="6" fill="{}"/>)",
      prefix, look.name, look.fill);
  if (*look.hatch) {
    text += fmt::format(R"(<path d="{}" stroke="{}" stroke-width="0.9" fill="none"/>)", look.hatch, look.ink);
  }
  return text + "</pattern>\n";
}

std::string draw_hatches(const std::string& prefix) {
  std::string text = "<defs>\n";
  for (const auto region :
       {Region::kArtifact, Region::kChanged, Region::kBoth, Region::kEquivalent, Region::kUntested}) {
    text += draw_hatch(prefix, region);
  }
  return text + "</defs>\n";
}

std::string draw_text(double x, double y, const char* anchor, int size, const std::string& text,
                      const char* more = "") {
  return fmt::format(R"(<text x="{}" y="{}" text-anchor="{}" font-size="{}" fill="{}"{}>{}</text>)"
                     "\n",
                     x, y, anchor, size, kInk, more, escape_xml(text));
}

std::string draw_lines(double x, double y, const std::vector<std::string>& lines, const char* more = "") {
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i)
    text += draw_text(x, y + kLine * static_cast<double>(i), "start", 8, lines[i], more);
  return text;
}

// Filled where flagged, open where not; nothing where untested.
std::string draw_dot(double x, double y, const Count& count) {
  if (count.n == 0) return "";
  return fmt::format(R"(<circle cx="{}" cy="{}" r="2.7" fill="{}" stroke="{}" stroke-width="1"/>)"
                     "\n",
                     x, y, is_flagged(count) ? kInk : "#ffffff", kInk);
}

std::string describe_count(const char* name, const Count& count) {
  return count.n > 0 ? fmt::format("{} {} of {}", name, count.k, count.n)
                     : fmt::format("{} not tested", name);
}

std::string draw_region(const std::string& prefix, Region region, double x, double y, bool observed) {
  return fmt::format(
      R"~(<rect class="cell" x="{}" y="{}" width="{}" height="{}" fill="url(#{}-{})" fill-opacity="{}" stroke="#ffffff" stroke-width="0.75"/>)~"
      "\n",
      x, y, kCellWidth, kCellHeight, prefix, look_of(region).name, observed ? "1" : "0.55");
}

std::string draw_letter(Region region, double x, double y, bool supported) {
  return draw_text(x + kCellWidth / 2.0, y + 11, "middle", 9, look_of(region).letter,
                   supported
                       ? R"( font-weight="bold" text-decoration="underline")"
                       : R"( paint-order="stroke" stroke="#ffffff" stroke-width="2" stroke-opacity="0.55")");
}

std::string draw_cell(const std::string& prefix, const ColumnFinding& column, const RuleFinding& finding,
                      std::size_t i, double x, double y) {
  const Count& artifact = column.artifact[i].count;
  const Count& material = column.material[i].count;
  const Region region = finding.regions[i];
  const int level = column.artifact[i].level;
  const bool supported =
      std::find(finding.supported.begin(), finding.supported.end(), level) != finding.supported.end();
  const std::string title = fmt::format("{}-{}: {}; {}; {}{}", format_key(column.column), format_clamp(level),
                                        format_region(region), describe_count("artifact", artifact),
                                        describe_count("material", material), supported ? "; supported" : "");
  return fmt::format("<g><title>{}</title>\n", escape_xml(title)) +
         draw_region(prefix, region, x, y, is_observed(column, region, i)) +
         draw_letter(region, x, y, supported) + draw_dot(x + 7, y + kCellHeight / 2.0, artifact) +
         draw_dot(x + kCellWidth - 7, y + kCellHeight / 2.0, material) + "</g>\n";
}

std::string draw_axis(const ColumnCounts& counts) {
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double y = kTop + kCellHeight * static_cast<double>(counts.size() - 1 - i);
    text += draw_text(kLeft - 4, y + 11, "end", 9, format_clamp(counts[i].level));
  }
  return text;
}

// Left of the levels, where a graph in a page has no room.
std::string name_axis(const ColumnCounts& counts) {
  const double middle = kTop + kCellHeight * static_cast<double>(counts.size()) / 2;
  const std::string name = fmt::format("clamp level, {} most clamped", format_clamp(counts.back().level));
  return fmt::format(R"~(<g transform="translate(-4 {}) rotate(-90)">{}</g>)~"
                     "\n",
                     middle, draw_text(0, 0, "middle", 9, name));
}

std::string open_svg(int width, int height, double scale, const std::string& label) {
  return fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="{2}" height="{3}" viewBox="0 0 {0} {1}" role="img" aria-label="{4}" font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif">)"
      "\n",
      width, height, width * scale, height * scale, escape_xml(label));
}

std::string describe_cut(Experiment experiment, const Threshold& threshold, const ColumnCounts& counts) {
  return fmt::format("{} cut {} ({})", format_experiment(experiment), format_cut(threshold),
                     describe_status(threshold, experiment, counts));
}

// The count below a column, with its cuts where the pointer rests.
std::string draw_count(const ColumnFinding& column, const RuleFinding& finding, double x, double y,
                       const char* mark) {
  const std::string title =
      fmt::format("{}: {}; {}", format_key(column.column),
                  describe_cut(Experiment::kArtifact, finding.artifact, column.artifact),
                  describe_cut(Experiment::kMaterial, finding.material, column.material));
  return fmt::format("<g><title>{}</title>\n", escape_xml(title)) +
         draw_text(x, y, "middle", 9, format_vpl_count(column.column.vpl_count) + mark) + "</g>\n";
}

bool has_reversed_flags(const RuleFinding& finding) {
  return !finding.artifact.flags_monotone || !finding.material.flags_monotone;
}

// The plot: axes, cells, counts. units: as the picture's, its corner at 0, 0
std::string draw_plot_of(const std::vector<const ColumnFinding*>& columns, Rule rule,
                         const std::string& prefix) {
  const ColumnCounts& first = columns.front()->artifact;
  const int plot_height = kCellHeight * static_cast<int>(first.size());
  std::string svg = draw_axis(first);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const RuleFinding& finding = columns[c]->under(rule);
    const double x = kLeft + kCellWidth * static_cast<double>(c);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double y = kTop + kCellHeight * static_cast<double>(first.size() - 1 - i);
      svg += draw_cell(prefix, *columns[c], finding, i, x, y);
    }
    svg += draw_count(*columns[c], finding, x + kCellWidth / 2.0, kTop + plot_height + 12,
                      has_reversed_flags(finding) ? "*" : "");
  }
  svg += fmt::format(
      R"(<rect x="{}" y="{}" width="{}" height="{}" fill="none" stroke="#6b6b6b" stroke-width="0.8"/>)"
      "\n",
      kLeft, kTop, kCellWidth * columns.size(), plot_height);
  return svg + draw_text(kLeft + kCellWidth * static_cast<double>(columns.size()) / 2,
                         kTop + plot_height + 25, "middle", 9, "VPLs");
}

struct Size {
  int width, height;
};

Size measure_graph(const std::vector<const ColumnFinding*>& columns) {
  return {kLeft + kCellWidth * static_cast<int>(columns.size()) + kRight,
          kTop + kCellHeight * static_cast<int>(columns.front()->artifact.size()) + kBottom};
}

std::string name_graph(const Object& object, Rule rule) {
  return fmt::format("Regions of {} under the rule {}", format_key(object), format_rule(rule));
}

constexpr const char* kLoneKey[] = {
    "A artifacts seen; M material looked different; AM both; E not shown to be different; ? not tested "
    "enough "
    "to say.",
    "E bold and underlined: supported at 95 %. Paler: inferred by the rule, not tested.",
    "Dots: tested, at the left for artifacts, at the right for the material; filled where 3/4 or more were "
    "correct.",
    "VPLs with a star: flags go back and forth, the rule decides."};

}  // namespace

std::string draw_graph(const Object& object, const std::vector<const ColumnFinding*>& columns, Rule rule,
                       const GraphPlace& place) {
  EQ_CHECK(!columns.empty(), format_key(object));
  const std::string key = format_key(object), prefix = key + place.study;
  const Size size = measure_graph(columns);
  return open_svg(size.width, size.height, place.scale, name_graph(object, rule)) + draw_hatches(prefix) +
         draw_text(kLeft, 14, "start", 11, key, R"( font-weight="bold")") +
         draw_plot_of(columns, rule, prefix) + "</svg>\n";
}

std::string draw_lone_graph(const Object& object, const std::vector<const ColumnFinding*>& columns, Rule rule,
                            const std::string& study, SubjectKind kind) {
  EQ_CHECK(!columns.empty(), format_key(object));
  const std::string key = format_key(object);
  const Size size = measure_graph(columns);
  const int width = std::max(size.width, kLoneWidth);
  const auto wrap = [&](const std::string& text) {
    return wrap_words(text, static_cast<std::size_t>((width - 8) / kLetter));
  };
  auto head = wrap(describe_subjects(kind));
  for (const std::string& line : wrap(fmt::format("study {}, rule {}", study, format_rule(rule))))
    head.push_back(line);
  std::vector<std::string> foot;
  for (const char* text : kLoneKey) {
    for (const std::string& line : wrap(text)) foot.push_back(line);
  }
  const int above = 18 + kLine * static_cast<int>(head.size()) - kTop + 10;
  const int height = above + size.height + kLine * static_cast<int>(foot.size()) + 10;
  return open_svg(width, height, 1, name_graph(object, rule) + ", " + describe_subjects(kind)) +
         draw_hatches(key) + draw_text(4, 14, "start", 11, key, R"( font-weight="bold")") +
         draw_lines(4, 28, head, R"( font-weight="bold")") +
         fmt::format("<g transform=\"translate({} {})\">\n", (width - size.width) / 2, above) +
         name_axis(columns.front()->artifact) + draw_plot_of(columns, rule, key) + "</g>\n" +
         draw_lines(4, above + size.height + 10, foot) + "</svg>\n";
}

std::string draw_legend(const std::string& name) {
  const std::string prefix = "legend" + name;
  struct Entry {
    Region region;
    const char* words;
  };
  const Entry entries[] = {{Region::kArtifact, "artifacts seen (from below)"},
                           {Region::kChanged, "material looked different (from above)"},
                           {Region::kBoth, "both"},
                           {Region::kEquivalent, "not shown to be different"},
                           {Region::kUntested, "not tested enough to say"}};
  std::string svg = open_svg(720, 70, 1, "Key to the graphs") + draw_hatches(prefix);
  double x = 2;
  double y = 4;
  for (const Entry& entry : entries) {
    if (entry.region == Region::kEquivalent) x = 2, y = 27;
    svg += draw_region(prefix, entry.region, x, y, true) + draw_letter(entry.region, x, y, false);
    svg += draw_text(x + kCellWidth + 6, y + 11, "start", 10, entry.words);
    x += entry.region == Region::kArtifact ? 225 : entry.region == Region::kChanged ? 275 : 195;
  }
  svg += draw_region(prefix, Region::kEquivalent, x + 55, y, false) +
         draw_text(x + 55 + kCellWidth + 6, y + 11, "start", 10, "paler: inferred by the rule, not tested");
  svg += draw_dot(8, 58, {9, 12}) + draw_dot(18, 58, {0, 12}) +
         draw_text(28, 61.5, "start", 10,
                   "tested: artifact experiment at the left, material at the right of a cell; filled where "
                   "3/4 or more "
                   "were correct. Underlined: supported at 95 %");
  return svg + "</svg>\n";
}

}  // namespace equilux
