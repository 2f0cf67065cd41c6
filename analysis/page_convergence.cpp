// What more rendering time buys, condition by condition.
#include <cctype>
#include <fmt/format.h>

#include "analysis/markup.h"
#include "analysis/page_sections.h"

namespace equilux {
namespace {

// As the address of an image: nothing in it can run, and its names stay its own.
std::string make_image_address(const std::string& svg) {
  std::string address = "data:image/svg+xml,";
  for (const char c : svg) {
    const auto byte = static_cast<unsigned char>(c);
    address += std::isalnum(byte) ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return address;
}

std::string format_plot(const ConvergenceExhibit& exhibit) {
  if (exhibit.svg.empty()) return "<p class=\"note\">No plot was drawn.</p>\n";
  return fmt::format(
      "<p><img alt=\"Error against run time of {}\" style=\"max-width:100%\" src=\"{}\"></p>\n",
      escape_xml(exhibit.convergence.condition), make_image_address(exhibit.svg));
}

std::string format_buys(const Convergence& convergence) {
  Table table{{"method", "setting", "wall s", "rms", "bias %", "FLIP", "pixels over one step %"}, {}};
  for (const ConvergencePoint* point : find_frontier(convergence)) {
    const ErrorFigures& error = point->error;
    table.rows.push_back({escape_xml(point->series), escape_xml(point->setting),
                          fmt::format("{:.2g}", point->wall()), format_error(convergence, *point),
                          fmt::format("{:+.2f}", 100 * error.bias), fmt::format("{:.4f}", error.flip),
                          fmt::format("{:.1f}", 100 * error.share_over_one_step)});
  }
  return format_html_table(table, 2);
}

std::string format_error_parts(const Convergence& convergence) {
  Table table{{"part of the error", "measured by", "rms %", "bias %"}, {}};
  for (const ErrorPart& part : convergence.parts)
    table.rows.push_back({escape_xml(part.name), escape_xml(part.measured_by),
                          fmt::format("{:.2f}", 100 * part.relative_rms),
                          fmt::format("{:+.2f} &plusmn; {:.2f}", 100 * part.bias, 100 * part.bias_error)});
  return format_html_table(table, 2);
}

// What a machine or a scene did not allow.
std::string format_left_out(const Convergence& convergence) {
  if (convergence.left_out.empty()) return "";
  std::string text = "<p>Not measured:</p>\n<ul>\n";
  for (const std::string& what : convergence.left_out) text += "<li>" + escape_xml(what) + "</li>\n";
  return text + "</ul>\n";
}

std::string format_exhibit(const ConvergenceExhibit& exhibit) {
  const Convergence& convergence = exhibit.convergence;
  return fmt::format(
      "<h3>{}, {}</h3>\n<p>{}</p>\n{}<p>Each row is nearer to the reference ({}; its standard error {:.2g} % "
      "rms) "
      "than all that take no longer, on {} threads at {} &times; {} pixels.</p>\n{}{}"
      "<details><summary>The error of this condition&rsquo;s picture in its parts</summary>\n{}</details>\n",
      escape_xml(convergence.source), escape_xml(convergence.condition),
      escape_xml(format_advice(convergence)), format_plot(exhibit), escape_xml(convergence.reference),
      100 * convergence.reference_rms, convergence.threads, convergence.width, convergence.height,
      format_buys(convergence), format_left_out(convergence), format_error_parts(convergence));
}

}  // namespace

std::string format_convergences(const Report& report) {
  if (report.convergences.empty()) return "";
  std::string text = "<section>\n<h2>Error against run time</h2>\n";
  for (const ConvergenceExhibit& exhibit : report.convergences) text += format_exhibit(exhibit);
  return text + "</section>\n";
}

}  // namespace equilux
