// Findings to gnuplot's commands, and running it.
#include "analysis/figure.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "analysis/markup.h"
#include "analysis/tables.h"
#include "base/error.h"
#include "base/files.h"
#include "base/gnuplot.h"

namespace equilux {
namespace {

// Pixels.
constexpr int kPanelWidth = 190;
constexpr int kPanelHeight = 225;
constexpr int kHeadLine = 17;        // height of a line of the head
constexpr double kHeadLetter = 6.5;  // width of a letter of the head, on average

struct Look {
  Region region;
  const char* letter;
  const char* colour;
  const char* hatch;  // gnuplot's fill style over a pale ground of the same colour
};

constexpr Look kLooks[] = {{Region::kArtifact, "A", "#e79ab0", "transparent pattern 4"},
                           {Region::kChanged, "M", "#cf4636", "transparent pattern 5"},
                           {Region::kBoth, "AM", "#c25560", "transparent pattern 2"},
                           {Region::kEquivalent, "E", "#93cf98", "solid 1.0"},
                           {Region::kUntested, "?", "#c9c9c4", "solid 0.25"}};

std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

// The colour of a cell that nobody was asked about: half way to white.
std::string make_paler(const std::string& colour) {
  std::string paler = "#";
  for (std::size_t i = 1; i < colour.size(); i += 2)
    paler += fmt::format("{:02x}", (std::stoi(colour.substr(i, 2), nullptr, 16) + 255) / 2);
  return paler;
}

FigurePanel make_panel(const Report& report, const Object& object, const std::string& title) {
  return {title, findings_of(report.findings, object)};
}

Figure make_grid(const Report& report, Illumination illumination) {
  const auto materials = enumerate_materials(report.study);
  Figure figure{fmt::format("figure-{}-{}", report.study.name, format_illumination(illumination)),
                fmt::format("{}, {}", report.study.name, describe_illumination(illumination)),
                report.evidence.kind,
                materials.size(),
                {}};
  for (const std::string& geometry : enumerate_geometries(report.study)) {
    for (const std::string& material : materials) {
      const Object object{geometry, material, illumination};
      figure.panels.push_back(make_panel(report, object, fmt::format("{} {}", geometry, material)));
    }
  }
  return figure;
}

// Objects of the normalised study that the plain one has too: a row each.
std::optional<Figure> make_normalised(const Report& plain, const Report& normalised) {
  // No study's name has a plus: the name of no grid comes out the same.
  Figure figure{fmt::format("figure-{}+{}", plain.study.name, normalised.study.name),
                fmt::format("{} and {}", plain.study.name, normalised.study.name),
                plain.evidence.kind,
                0,
                {}};
  std::vector<FigurePanel> lower;
  for (const Object& object : enumerate_objects(normalised.study)) {
    if (findings_of(plain.findings, object).empty()) continue;
    figure.panels.push_back(make_panel(plain, object, format_key(object)));
    lower.push_back(make_panel(normalised, object, format_key(object) + ", normalised"));
  }
  if (lower.empty()) return std::nullopt;
  figure.width = lower.size();
  figure.panels.insert(figure.panels.end(), lower.begin(), lower.end());
  return figure;
}

// x, y and half of each side, of the cells of a region that were asked about, or were not.
std::string format_cells_data(const FigurePanel& panel, Rule rule, Region region, bool observed) {
  std::string rows;
  for (std::size_t x = 0; x < panel.columns.size(); ++x) {
    const auto& regions = panel.columns[x]->under(rule).regions;
    for (std::size_t y = 0; y < regions.size(); ++y) {
      if (regions[y] == region && is_observed(*panel.columns[x], region, y) == observed)
        rows += fmt::format("{} {} 0.5 0.5\n", x + 1, y);
    }
  }
  return rows;
}

// The same of the frames within supported cells.
std::string format_supported_data(const FigurePanel& panel, Rule rule) {
  std::string rows;
  for (std::size_t x = 0; x < panel.columns.size(); ++x) {
    const ColumnFinding& column = *panel.columns[x];
    const auto& supported = column.under(rule).supported;
    for (std::size_t y = 0; y < column.artifact.size(); ++y) {
      if (std::find(supported.begin(), supported.end(), column.artifact[y].level) != supported.end())
        rows += fmt::format("{} {} 0.42 0.40\n", x + 1, y);
    }
  }
  return rows;
}

std::string format_axes(const FigurePanel& panel) {
  std::string x, y;
  for (std::size_t i = 0; i < panel.columns.size(); ++i) {
    x += fmt::format("{}'{}' {}", i > 0 ? ", " : "", format_vpl_count(panel.columns[i]->column.vpl_count),
                     i + 1);
  }
  const ColumnCounts& counts = panel.columns.front()->artifact;
  for (std::size_t i = 0; i < counts.size(); ++i)
    y += fmt::format("{}'{}' {}", i > 0 ? ", " : "", format_clamp(counts[i].level), i);
  return fmt::format(
      "set xrange [0.5:{}.5]\nset yrange [-0.5:{}.5]\nset xtics ({})\nset ytics ({})\n"
      "set xlabel 'VPLs' font ',8' offset 0,0.6\n"
      "set ylabel 'clamp level, {} most clamped' font ',8' offset 1.8,0\n",
      panel.columns.size(), counts.size() - 1, x, y, format_clamp(counts.back().level));
}

std::string format_look(const Look& look, int block, bool observed) {
  const std::string colour = observed ? look.colour : make_paler(look.colour);
  return fmt::format(
      "$b{0} using 1:2:3:4 with boxxyerror fs solid {1} noborder fc rgb '{2}' notitle, "
      "$b{0} using 1:2:3:4 with boxxyerror fs {3} border lc rgb '#ffffff' fc rgb '{2}' notitle",
      block, observed ? 0.4 : 0.2, colour,
      look.region == Region::kEquivalent && !observed ? "solid 0.4" : look.hatch);
}

std::string format_panel(const FigurePanel& panel, Rule rule) {
  if (panel.columns.empty()) return "set multiplot next\n";
  std::string text = fmt::format("set title {} offset 0,-0.7\n", quote(panel.title)) + format_axes(panel);
  std::string plot, labels;
  int block = 0;
  for (const Look& look : kLooks) {
    for (const bool observed : {true, false}) {
      const std::string rows = format_cells_data(panel, rule, look.region, observed);
      if (rows.empty()) continue;
      text += fmt::format("$b{} << EOD\n{}EOD\n", block, rows);
      plot += (plot.empty() ? "plot " : ", ") + format_look(look, block, observed);
      labels += fmt::format(", $b{} using 1:2:('{}') with labels font ',8' tc rgb '#1c1c1c' notitle", block,
                            observed ? std::string(look.letter) : fmt::format("({})", look.letter));
      ++block;
    }
  }
  if (const std::string rows = format_supported_data(panel, rule); !rows.empty()) {
    text += fmt::format("$supported << EOD\n{}EOD\n", rows);
    labels +=
        ", $supported using 1:2:3:4 with boxxyerror fs empty lc rgb '#1c1c1c' lw 1.2 notitle"
        ", $supported using 1:2:('E') with labels font 'DejaVu Sans:Bold,8' tc rgb '#1c1c1c' notitle";
  }
  return text + plot + labels + "\n";
}

// Whose answers, by what rule, and the key; in lines that fit the figure.
std::vector<std::string> make_head(const Figure& figure, Rule rule, int width) {
  const auto most = static_cast<std::size_t>(width / kHeadLetter);
  std::vector<std::string> lines;
  for (const std::string& text :
       {fmt::format("{}, rule {}", figure.title, format_rule(rule)), describe_subjects(figure.kind),
        std::string("A artifacts; M material looked different; AM both; E equivalent; E bold, in a frame: "
                    "supported at 95 %; ? not tested; (in brackets), paler: inferred by the rule, not "
                    "tested")}) {
    for (const std::string& line : wrap_words(text, most)) lines.push_back(line);
  }
  return lines;
}

// Single-quoted, so that no name can say anything to gnuplot.
std::string quote_lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : ".\"\\n\".") + quote(line);
  return text;
}

// gnuplot knows files alone. Removed at the end of its scope.
class DrawingFolder {
 public:
  DrawingFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "equilux-figures-XXXXXX").string();
    if (!::mkdtemp(name.data())) throw StoreError(fmt::format("{}: expected a new folder, got none", name));
    path_ = name;
  }
  ~DrawingFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  DrawingFolder(const DrawingFolder&) = delete;
  DrawingFolder& operator=(const DrawingFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// The same plot is the same bytes: cairo writes the time of day into a PDF's information, which need not have
// it. Blanked, so that every other byte stays where the PDF's table says it is.
void blank_creation_date(const std::filesystem::path& file) {
  constexpr std::string_view kDate = "/CreationDate (";
  std::string bytes = load_text(file);
  const std::size_t begin = bytes.starts_with("%PDF") ? bytes.rfind(kDate) : std::string::npos;
  const std::size_t end = begin == std::string::npos ? begin : bytes.find(')', begin);
  if (end == std::string::npos) return;
  std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(begin),
            bytes.begin() + static_cast<std::ptrdiff_t>(end) + 1, ' ');
  save_text(file, bytes);
}

}  // namespace

std::vector<Figure> make_figures(const std::vector<Report>& reports) {
  std::vector<Figure> figures;
  for (const Report& report : reports) {
    for (const Illumination illumination : enumerate_illuminations(report.study))
      figures.push_back(make_grid(report, illumination));
  }
  for (const Report& normalised : reports) {
    for (const Report& plain : reports) {
      if (!normalised.study.normalise || plain.study.normalise) continue;
      if (auto figure = make_normalised(plain, normalised)) figures.push_back(std::move(*figure));
    }
  }
  return figures;
}

std::string format_terminal(FigureFormat format, int width, int height, const std::filesystem::path& file) {
  const std::string terminal =
      format == FigureFormat::kSvg
          ? fmt::format("svg size {},{} dynamic font 'DejaVu Sans,10' background '#ffffff'", width, height)
          : fmt::format("pdfcairo size {:.3f}in,{:.3f}in font 'DejaVu Sans,10' fontscale 0.55", width / 96.0,
                        height / 96.0);
  return fmt::format("set terminal {}\nset output {}\n", terminal, quote(file.string()));
}

std::string format_figure(const Figure& figure, Rule rule, FigureFormat format,
                          const std::filesystem::path& file) {
  EQ_CHECK(figure.width > 0 && figure.panels.size() % figure.width == 0, figure.width, figure.panels.size());
  const std::size_t rows = figure.panels.size() / figure.width;
  const int width = std::max(kPanelWidth * static_cast<int>(figure.width), 2 * kPanelWidth);
  const std::vector<std::string> head = make_head(figure, rule, width);
  const int head_height = kHeadLine * static_cast<int>(head.size()) + 6;
  const int height = kPanelHeight * static_cast<int>(rows) + head_height;
  std::string text = format_terminal(format, width, height, file);
  text += fmt::format("set multiplot layout {},{} rowsfirst title {} noenhanced\n", rows, figure.width,
                      quote_lines(head));
  text += "set tics scale 0 font ',8'\nset border lc rgb '#666666'\nset termoption noenhanced\n";
  for (const FigurePanel& panel : figure.panels) text += format_panel(panel, rule);
  return text + "unset multiplot\n";
}

void draw_plot(const std::filesystem::path& file,
               const std::function<std::string(const std::filesystem::path&)>& make) {
  save_atomically(file, [&](const std::filesystem::path& part) {
    const int status = run_gnuplot(make(part));
    if (status == kNoGnuplot) {
      throw InputError("gnuplot", "", "one with SVG and PDF (Debian package gnuplot-nox), or --no-plot",
                       "none");
    }
    if (status != 0)
      throw StoreError(fmt::format("{}: cannot draw: gnuplot ended with status {}", file.string(), status));
    blank_creation_date(part);
  });
}

ReportFiles draw_figures(const std::vector<Report>& reports) {
  const Rule rule = reports.front().rule;
  const DrawingFolder folder;
  ReportFiles files;
  for (const Figure& figure : make_figures(reports)) {
    for (const auto& [format, end] : {std::pair(FigureFormat::kSvg, ".svg"), {FigureFormat::kPdf, ".pdf"}}) {
      const FigureFormat wanted = format;
      const std::filesystem::path file = folder.path() / (figure.name + end);
      draw_plot(file,
                [&](const std::filesystem::path& part) { return format_figure(figure, rule, wanted, part); });
      files[file.filename().string()] = load_text(file);
    }
  }
  return files;
}

}  // namespace equilux
