// The page: its template and what goes into each place.
#include "analysis/graph.h"
#include "analysis/markup.h"
#include "analysis/page_sections.h"
#include "base/version.h"

namespace equilux {

extern const char kPageTemplate[];
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

}  // namespace

std::string format_page(const Report& report) {
  return fill_template(kPageTemplate, {{"version", kVersion},
                                       {"name", escape_xml(report.study.name)},
                                       {"kind", format_kind(report.evidence.kind)},
                                       {"rule", format_rule(report.rule)},
                                       {"style", kPageStyle},
                                       {"summary", format_summary(report)},
                                       {"banner", format_banner(report)},
                                       {"warnings", format_warnings(report)},
                                       {"asked", format_asked(report)},
                                       {"answered", format_answered(report)},
                                       {"ee", format_ee_squares(report)},
                                       {"star_note", format_star_note(report)},
                                       {"legend", draw_legend()},
                                       {"graphs", format_graphs(report)},
                                       {"counting", format_counting(report)},
                                       {"monotone", format_monotone(report)},
                                       {"rules", format_rule_differences(report)},
                                       {"noise", format_noise(report)},
                                       {"convergences", format_convergences(report)},
                                       {"cells", format_cells(report)},
                                       {"provenance", format_provenance(report)}});
}

}  // namespace equilux
