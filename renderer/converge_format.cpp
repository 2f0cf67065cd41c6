// CSV and Markdown.
#include "renderer/converge_format.h"

#include <fmt/format.h>

namespace equilux {
namespace {

std::string format_csv_text(const std::string& text) {
  return text.find(',') == std::string::npos ? text : "\"" + text + "\"";
}

template <typename Number>
std::string format_known(Number number, bool known) {
  return known ? fmt::format("{}", number) : "";
}

std::string format_stages(const std::map<std::string, double>& stages) {
  std::string text;
  for (const auto& [stage, seconds] : stages)
    text += fmt::format("{}{} {:.4g}", text.empty() ? "" : "; ", stage, seconds);
  return text;
}

std::string format_csv_row(const ConvergencePoint& point) {
  const ErrorFigures& error = point.error;
  return fmt::format(
      "{},{},{},{},{},{},{},{:.6g},{:.6g},{},{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g}\n",
      format_csv_text(point.series), format_csv_text(point.setting), format_known(point.vpls, point.vpls > 0),
      format_known(point.error_ratio, point.error_ratio > 0),
      format_known(point.clamp_level.value_or(0), point.clamp_level.has_value()),
      format_known(point.paths_a_pixel, point.paths_a_pixel > 0), format_known(point.sets, point.sets > 0),
      point.wall(), point.cpu(), format_stages(point.wall_s), format_stages(point.cpu_s), error.relative_rms,
      error.relative_rms_error, error.relative_mse, error.bias, error.bias_low, error.bias_high, error.flip,
      error.share_over_one_step);
}

std::string describe_reference(const Convergence& convergence) {
  return fmt::format("{}, standard error {:.2g} % rms", convergence.reference,
                     100 * convergence.reference_rms);
}

std::string format_header(const Convergence& convergence) {
  return fmt::format(
      "{} x {} pixels, {} subpixel positions, {} threads, {} seeds a setting from {}, instruction set {}. "
      "The "
      "object covers {} pixels, its mean radiance is {:.4g} W/(m^2 sr). Reference: {}.\n",
      convergence.width, convergence.height, convergence.positions, convergence.threads, convergence.seeds,
      convergence.seed, convergence.isa, convergence.object_pixels, convergence.reference_mean,
      describe_reference(convergence));
}

std::string format_parts(const Convergence& convergence) {
  std::string text = "| part | rms % | bias % | measured by |\n|---|---:|---:|---|\n";
  for (const ErrorPart& part : convergence.parts)
    text += fmt::format("| {} | {:.2f} | {:+.2f} ± {:.2f} | {} |\n", part.name, 100 * part.relative_rms,
                        100 * part.bias, 100 * part.bias_error, part.measured_by);
  return text;
}

std::string format_left_out(const Convergence& convergence) {
  std::string text;
  for (const std::string& what : convergence.left_out) text += fmt::format("- {}\n", what);
  return text.empty() ? "" : "\nLeft out:\n\n" + text;
}

std::string format_rms(const Convergence& convergence, const ConvergencePoint& point) {
  if (!is_resolved(convergence, point)) return format_error(convergence, point);
  return fmt::format("{:.2f} ± {:.2f}", 100 * point.error.relative_rms, 100 * point.error.relative_rms_error);
}

std::string format_rows(const Convergence& convergence, const std::string& series) {
  std::string text;
  for (const ConvergencePoint& point : convergence.points) {
    if (point.series != series) continue;
    const ErrorFigures& error = point.error;
    text += fmt::format(
        "| {} | {} | {:.3g} | {:.3g} | {} | {:.3g} | {:+.2f} ({:+.2f} to {:+.2f}) | {:.4f} | {:.1f} |\n",
        series, point.setting, point.wall(), point.cpu(), format_rms(convergence, point), error.relative_mse,
        100 * error.bias, 100 * error.bias_low, 100 * error.bias_high, error.flip,
        100 * error.share_over_one_step);
  }
  return text;
}

std::string format_frontier(const Convergence& convergence) {
  std::string text = "| within | method | setting | rms |\n|---:|---|---|---:|\n";
  for (const ConvergencePoint* point : find_frontier(convergence))
    text += fmt::format("| {:.2g} s | {} | {} | {} |\n", point->wall(), point->series, point->setting,
                        format_error(convergence, *point));
  return text;
}

std::string format_slopes(const Convergence& convergence) {
  std::string text = "| curve | slope |\n|---|---:|\n";
  for (const std::string& series : list_series(convergence)) {
    if (const auto slope = find_slope(convergence, series))
      text += fmt::format("| {} | {:.2f} |\n", series, *slope);
  }
  return text;
}

}  // namespace

std::string format_convergence_csv(const Convergence& convergence) {
  std::string text =
      "series,setting,vpls,error_ratio,clamp_level,paths_a_pixel,sets,wall_s,cpu_s,wall_stages_s,cpu_stages_"
      "s,"
      "relative_rms,relative_rms_error,relative_mse,bias,bias_low,bias_high,flip,share_over_one_step\n";
  for (const ConvergencePoint& point : convergence.points) text += format_csv_row(point);
  return text;
}

std::string format_convergence_page(const Convergence& convergence, const std::string& plot_file) {
  std::string text = fmt::format("## {}, {}\n\n{}\n\n", convergence.source, convergence.condition,
                                 format_advice(convergence));
  if (!plot_file.empty()) text += fmt::format("![Error against run time]({})\n\n", plot_file);
  text += format_header(convergence) + "\nWhat more time buys:\n\n" + format_frontier(convergence);
  text += format_left_out(convergence);
  if (!convergence.parts.empty())
    text += "\nThe error of the condition's own picture in its parts:\n\n" + format_parts(convergence);
  text += "\nSlopes of log error over log time, of curves whose times differ twofold or more:\n\n" +
          format_slopes(convergence);
  text +=
      "\nEvery setting:\n\n| curve | setting | wall s | CPU s | rms % | relative MSE | bias % (95 %) | FLIP "
      "| "
      "pixels over one step % |\n|---|---|---:|---:|---:|---:|---:|---:|---:|\n";
  for (const std::string& series : list_series(convergence)) text += format_rows(convergence, series);
  return text;
}

}  // namespace equilux
