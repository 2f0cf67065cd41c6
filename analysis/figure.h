// The paper's Figures 4, 7, 9 and 12 as files for print, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "analysis/report.h"

namespace equilux {

/// A small graph of a figure: an object's columns from few to many VPLs.
struct FigurePanel {
  std::string title;
  std::vector<const ColumnFinding*> columns;  ///< none: the place stays empty
};

struct Figure {
  std::string name;  ///< of its files: figure-paper-ind
  std::string title;
  SubjectKind kind = SubjectKind::kPerson;  ///< whose answers it shows
  std::size_t width = 0;                    ///< panels in a row
  std::vector<FigurePanel> panels;          ///< shape: row by row
};

/// For each study and illumination a row for each geometry and a column for each material (Figures 4, 7 and
/// 9); for a normalised study with objects of a plain one a row plain and a row normalised (Figure 12).
/// Figures point into the reports.
std::vector<Figure> make_figures(const std::vector<Report>& reports);
std::vector<Figure> make_figures(std::vector<Report>&& reports) = delete;

enum class FigureFormat { kSvg, kPdf };

/// Commands for gnuplot that draw the figure into a file. Its head says whose answers it shows, by what rule,
/// and what the letters mean; every region has a colour, a hatch and a letter, in brackets and paler where
/// nobody was asked; a supported level has a frame and a bold letter.
std::string format_figure(const Figure& figure, Rule rule, FigureFormat format,
                          const std::filesystem::path& file);

/// All figures as SVG and PDF. errors: InputError where gnuplot cannot be run, StoreError where it cannot
/// draw.
ReportFiles draw_figures(const std::vector<Report>& reports);

/// Draws by gnuplot's commands, in which `make` names the file. errors: as draw_figures.
void draw_plot(const std::filesystem::path& file,
               const std::function<std::string(const std::filesystem::path&)>& make);

/// The first line of a plot: terminal and output. units: pixels of 1/96 inch.
std::string format_terminal(FigureFormat format, int width, int height, const std::filesystem::path& file);

}  // namespace equilux
