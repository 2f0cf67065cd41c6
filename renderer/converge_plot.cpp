// gnuplot: its commands, and running it.
#include "renderer/converge_plot.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/gnuplot.h"

namespace equilux {
namespace {

// Of gnuplot, which doubles what would end it.
std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::string format_plot_data(const Convergence& convergence, const std::string& series) {
  std::string rows;
  for (const ConvergencePoint& point : convergence.points) {
    if (point.series == series && is_resolved(convergence, point))
      rows += fmt::format("{:.6g} {:.6g} {:.6g}\n", point.wall(), 100 * point.error.relative_rms,
                          100 * point.error.relative_rms_error);
  }
  return rows;
}

// Up to what the reference can tell, then level to the end.
std::string format_frontier_data(const Convergence& convergence) {
  std::string rows;
  double error = 0, last = 0;
  for (const ConvergencePoint* point : find_frontier(convergence)) {
    error = 100 * std::max(point->error.relative_rms, find_least_error(convergence));
    if (error > 0) rows += fmt::format("{:.6g} {:.6g}\n", point->wall(), error);
  }
  for (const ConvergencePoint& point : convergence.points) last = std::max(last, point.wall());
  return error > 0 ? rows + fmt::format("{:.6g} {:.6g}\n", last, error) : rows;
}

struct Range {
  double low, high;
};

// 1, 2 and 5 of each decade.
std::string format_tics(const char* axis, const Range& range) {
  std::string tics;
  for (double decade = std::pow(10, std::floor(std::log10(range.low))); decade <= range.high; decade *= 10) {
    for (const double tic : {decade, 2 * decade, 5 * decade}) {
      if (tic < range.low || tic > range.high) continue;
      tics += fmt::format("{}{:.6g}", tics.empty() ? "" : ", ", tic);
    }
  }
  return fmt::format("set {}range [{:.6g}:{:.6g}]\nset {}tics ({})\n", axis, range.low, range.high, axis,
                     tics);
}

// All points and the reference's noise, with some room.
std::string format_ranges(const Convergence& convergence) {
  std::vector<double> times, errors;
  if (convergence.reference_rms > 0) errors.push_back(100 * find_least_error(convergence));
  for (const ConvergencePoint& point : convergence.points) {
    if (!is_resolved(convergence, point)) continue;
    times.push_back(point.wall());
    errors.push_back(100 * point.error.relative_rms);
  }
  if (times.empty()) return "";
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  const auto [least, most] = std::minmax_element(errors.begin(), errors.end());
  return format_tics("x", {*first * 0.8, *last * 1.25}) + format_tics("y", {*least * 0.7, *most * 1.4});
}

// Told apart by colour and by mark. source: Okabe and Ito's palette for all kinds of colour vision.
constexpr const char* kColours[] = {"#000000", "#e69f00", "#56b4e9", "#009e73",
                                    "#0072b2", "#d55e00", "#cc79a7"};

}  // namespace

std::string format_convergence_plot(const Convergence& convergence, PlotFormat format,
                                    const std::filesystem::path& file) {
  std::string text = fmt::format("set terminal {}\nset output {}\n",
                                 format == PlotFormat::kSvg
                                     ? "svg size 1100,640 dynamic font 'DejaVu Sans,13' background '#ffffff'"
                                     : "pngcairo size 1100,640 font 'DejaVu Sans,10'",
                                 quote(file.string()));
  text += fmt::format(
      "set title {} noenhanced\n",
      quote(fmt::format("{}, {}: error against run time", convergence.source, convergence.condition)));
  text += "set logscale xy\nset xlabel 'wall time, s (indirect light of the object)'\n";
  text += "set ylabel 'relative rms error of radiance, %'\n";
  text += "set grid xtics ytics mxtics mytics lc rgb '#cccccc', lc rgb '#e8e8e8'\n";
  text += "set key outside right top Left reverse noenhanced samplen 3\n";
  text += "set mxtics 10\nset mytics 10\nset border lc rgb '#666666'\n" + format_ranges(convergence);
  std::string plot = "plot $frontier with steps lw 7 lc rgb '#d9d9d9' title 'nearest to the truth so far'";
  text += "$frontier << EOD\n" + format_frontier_data(convergence) + "EOD\n";
  std::size_t index = 0;
  for (const std::string& series : list_series(convergence)) {
    const std::string rows = format_plot_data(convergence, series);
    if (rows.empty()) continue;
    text += fmt::format("$s{} << EOD\n{}EOD\n", index, rows);
    const auto slope = find_slope(convergence, series);
    plot += fmt::format(
        ", $s{} using 1:2:3 with yerrorlines lw 1.5 dt {} pt {} ps 0.8 lc rgb '{}' title '{}{}'", index,
        index / std::size(kColours) + 1, index % 13 + 4, kColours[index % std::size(kColours)], series,
        slope ? fmt::format(", slope {:.2f}", *slope) : "");
    ++index;
  }
  if (convergence.reference_rms == 0) return text + plot + "\n";
  return text + plot +
         fmt::format(", {:.6g} with lines dt 3 lw 1.5 lc rgb '#888888' title 'noise of the reference'\n",
                     100 * convergence.reference_rms);
}

bool can_be_drawn(const Convergence& convergence) {
  return std::any_of(convergence.points.begin(), convergence.points.end(),
                     [&](const ConvergencePoint& point) { return is_resolved(convergence, point); });
}

void check_gnuplot() {
  if (run_gnuplot("set terminal svg\nset terminal pngcairo\n") != 0)
    throw InputError("gnuplot", "", "one with SVG and PNG (Debian package gnuplot-nox), or --no-plot",
                     "none");
}

void draw_convergence(const Convergence& convergence, PlotFormat format, const std::filesystem::path& file) {
  save_atomically(file, [&](const std::filesystem::path& part) {
    if (const int status = run_gnuplot(format_convergence_plot(convergence, format, part)); status != 0)
      throw StoreError(fmt::format("{}: cannot draw: gnuplot ended with status {}", file.string(), status));
  });
}

}  // namespace equilux
