// The page: its template and what goes into each place.
#include "analysis/graph.h"
#include "analysis/markup.h"
#include "analysis/page_sections.h"
#include "base/error.h"
#include "base/version.h"

namespace equilux {

extern const char kPageTemplate[];
extern const char kStudyTemplate[];
extern const char kPageStyle[];

namespace {

std::string format_star_note(const Report& report) {
  for (const ColumnFinding& finding : report.findings) {
    const RuleFinding& under = finding.under(report.rule);
    if (under.artifact.flags_monotone && under.material.flags_monotone) continue;
    return " A VPL count with a star has flags that go back and forth: there the rule decides.";
  }
  return "";
}

std::string format_title(const Report& report, bool alone) {
  return alone ? "" : fmt::format("<h1 class=\"study\">Study {}</h1>", escape_xml(report.study.name));
}

std::string format_study(const Report& report, bool alone) {
  return fill_template(kStudyTemplate,
                       {{"name", escape_xml(report.study.name)},
                        {"title", format_title(report, alone)},
                        {"warnings", format_warnings(report)},
                        {"asked", format_asked(report)},
                        {"answered", format_answered(report)},
                        {"ee", format_ee_squares(report)},
                        {"star_note", format_star_note(report)},
                        {"legend", draw_legend(report.study.name)},
                        {"graphs", format_graphs(report)},
                        {"uncertainty", format_uncertainty(report)},
                        {"recovery", format_recovery(report)},
                        {"trends", format_trends(report)},
                        {"subjects", format_subjects(report)},
                        {"counting", format_counting(report)},
                        {"monotone", format_monotone(report)},
                        {"rules", format_rule_differences(report) + format_rule_certainty(report)},
                        {"noise", format_noise(report)},
                        {"convergences", format_convergences(report)},
                        {"cells", format_cells(report)},
                        {"provenance", format_provenance(report)}});
}

std::string format_names(const std::vector<Report>& reports) {
  std::vector<std::string> names;
  for (const Report& report : reports) names.push_back(report.study.name);
  return escape_xml(fmt::format("{} {}", reports.size() > 1 ? "studies" : "study", fmt::join(names, ", ")));
}

std::string format_leads(const std::vector<Report>& reports) {
  std::string text;
  for (const Report& report : reports) {
    const std::string name =
        reports.size() > 1 ? fmt::format("<b>{}.</b> ", escape_xml(report.study.name)) : "";
    text += fmt::format("<p class=\"lead\">{}{}</p>\n", name, format_summary(report));
  }
  return text;
}

std::string format_contents(const std::vector<Report>& reports) {
  if (reports.size() < 2) return "";
  std::string text;
  for (const Report& report : reports)
    text += fmt::format(R"(<li><a href="#study-{0}">Study {0}</a></li>)", escape_xml(report.study.name));
  return "<ul class=\"contents\">" + text + "</ul>\n";
}

}  // namespace

std::string format_page(const std::vector<Report>& reports) {
  EQ_CHECK(!reports.empty());
  std::string studies;
  for (const Report& report : reports) studies += format_study(report, reports.size() == 1);
  return fill_template(kPageTemplate, {{"version", kVersion},
                                       {"names", format_names(reports)},
                                       {"kind", format_kind(reports.front().evidence.kind)},
                                       {"rule", format_rule(reports.front().rule)},
                                       {"style", kPageStyle},
                                       {"leads", format_leads(reports)},
                                       {"contents", format_contents(reports)},
                                       {"banner", format_banner(reports.front())},
                                       {"studies", studies},
                                       {"tracing", format_tracing(reports)}});
}

}  // namespace equilux
