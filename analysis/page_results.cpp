// The page's results: the banner, the EE squares, the graphs, and where columns and rules are odd.
#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "analysis/graph.h"
#include "analysis/markup.h"
#include "analysis/page_sections.h"
#include "analysis/tables.h"
#include "analysis/words.h"

namespace equilux {
namespace {

std::size_t count_verdicts(const Report& report, Verdict verdict) {
  return static_cast<std::size_t>(std::count_if(
      report.findings.begin(), report.findings.end(),
      [&](const ColumnFinding& finding) { return finding.under(report.rule).verdict == verdict; }));
}

// Columns in which none is equivalent, without an answer of the material experiment.
std::size_t count_unasked(const Report& report) {
  return static_cast<std::size_t>(
      std::count_if(report.findings.begin(), report.findings.end(), [&](const ColumnFinding& finding) {
        const auto has_answers = [](const LevelCount& level) { return level.count.n > 0; };
        return finding.under(report.rule).verdict == Verdict::kNone &&
               std::none_of(finding.material.begin(), finding.material.end(), has_answers);
      }));
}

// Columns without a verdict under the page's rule, since another one left no level to ask about.
std::size_t count_dropped(const Report& report) {
  const auto& columns = report.uncertainty.columns;
  return static_cast<std::size_t>(
      std::count_if(columns.begin(), columns.end(), [&](const ColumnUncertainty& column) {
        return column.under(report.rule).status == UncertaintyStatus::kDropped;
      }));
}

std::string format_square(const Column& column, const RuleFinding& finding) {
  const char* sign = finding.verdict == Verdict::kExists ? "+"
                     : finding.verdict == Verdict::kNone ? "&minus;"
                                                         : "?";
  const std::string levels = finding.green.empty() ? "" : ", at " + format_levels(finding.green);
  const std::string supported =
      finding.supported.empty() ? "" : "; supported at " + format_levels(finding.supported);
  return fmt::format(R"(<span class="square {}{}" title="{}: {}{}{}">{}</span>)",
                     format_verdict(finding.verdict), finding.supported.empty() ? "" : " supported",
                     escape_xml(format_key(column)), format_verdict(finding.verdict), levels, supported,
                     sign);
}

std::string format_object_squares(const Report& report, const Object& object) {
  std::string squares;
  const auto columns = findings_of(report.findings, object);
  for (const std::int64_t vpl_count : enumerate_vpl_counts(report.study, object.illumination)) {
    const auto found = std::find_if(columns.begin(), columns.end(), [&](const auto* column) {
      return column->column.vpl_count == vpl_count;
    });
    squares += found == columns.end() ? R"(<span class="square absent"></span>)"
                                      : format_square((*found)->column, (*found)->under(report.rule));
  }
  return squares;
}

// Five materials of three VPL counts fill the page at scale 1; fewer leave room, more need it.
std::string format_object_graph(const Report& report, const Object& object) {
  const auto columns = findings_of(report.findings, object);
  const std::size_t materials = enumerate_materials(report.study).size();
  const double scale = materials > 5 ? 0.8 : materials > 3 ? 1 : 1.5;
  return columns.empty() ? "" : draw_graph(object, columns, report.rule, {scale, report.study.name});
}

// A row for each geometry, a column for each material, as in the paper's Figure 4.
template <typename Draw>
std::string format_object_grid(const Report& report, Illumination illumination, const char* style,
                               const std::string& caption, const Draw& draw) {
  std::string text = fmt::format(
      R"(<div class="grid"><table class="{}"><caption>{}</caption><thead><tr><th></th>)", style, caption);
  for (const auto& material : enumerate_materials(report.study))
    text += "<th>" + escape_xml(material) + "</th>";
  text += "</tr></thead><tbody>\n";
  for (const auto& geometry : enumerate_geometries(report.study)) {
    text += fmt::format(R"(<tr><th class="row">{}</th>)", escape_xml(geometry));
    for (const auto& material : enumerate_materials(report.study)) {
      text += "<td>" + draw(report, Object{geometry, material, illumination}) + "</td>\n";
    }
    text += "</tr>\n";
  }
  return text + "</tbody></table></div>\n";
}

std::string format_counts(const ColumnCounts& counts) {
  std::string text;
  for (const LevelCount& level : counts) {
    if (level.count.n == 0) continue;
    text += fmt::format("{}{} {}/{}{}", text.empty() ? "" : ", ", format_clamp(level.level), level.count.k,
                        level.count.n, is_flagged(level.count) ? "&thinsp;&#9679;" : "");
  }
  return text;
}

std::string format_cut_and_status(const Threshold& threshold, Experiment experiment,
                                  const ColumnCounts& counts) {
  const std::string cut = format_cut(threshold);
  return fmt::format("{} <span class=\"note\">{}</span>", cut == "-" ? "&ndash;" : escape_xml(cut),
                     describe_status(threshold, experiment, counts));
}

const Threshold& threshold_of(const RuleFinding& finding, Experiment experiment) {
  return experiment == Experiment::kArtifact ? finding.artifact : finding.material;
}

template <typename Wanted>
Table collect_columns(const Report& report, const Wanted& wanted) {
  Table table{{"column", "experiment", "correct of n, &#9679; flagged", "cut, paper", "cut, isotonic"}, {}};
  for (const ColumnFinding& finding : report.findings) {
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      const Threshold& paper = threshold_of(finding.under(Rule::kPaper), experiment);
      const Threshold& isotonic = threshold_of(finding.under(Rule::kIsotonic), experiment);
      if (!wanted(paper)) continue;
      const ColumnCounts& counts = experiment == Experiment::kArtifact ? finding.artifact : finding.material;
      table.rows.push_back({escape_xml(format_key(finding.column)), format_experiment(experiment),
                            format_counts(counts), format_cut_and_status(paper, experiment, counts),
                            format_cut_and_status(isotonic, experiment, counts)});
    }
  }
  return table;
}

Table collect_untested(const Report& report) {
  Table table{{"column", "rule", "artifact cut", "levels it would test, not tested"}, {}};
  for (const ColumnFinding& finding : report.findings) {
    for (const Rule rule : kRules) {
      const RuleFinding& under = finding.under(rule);
      if (under.untested.empty()) continue;
      table.rows.push_back({escape_xml(format_key(finding.column)), format_rule(rule),
                            format_cut_and_status(under.artifact, Experiment::kArtifact, finding.artifact),
                            format_levels(under.untested)});
    }
  }
  return table;
}

Table collect_verdict_differences(const Report& report) {
  Table table{{"column", "paper", "isotonic"}, {}};
  for (const ColumnFinding& finding : report.findings) {
    const RuleFinding& paper = finding.under(Rule::kPaper);
    const RuleFinding& isotonic = finding.under(Rule::kIsotonic);
    if (paper.verdict == isotonic.verdict && paper.green == isotonic.green) continue;
    const auto describe = [&](const RuleFinding& under) {
      if (!under.green.empty()) return fmt::format("exists, at {}", format_levels(under.green));
      return format_verdict(under.verdict) +
             (under.verdict == Verdict::kUntested && finding.dropped ? ", dropped by pruning" : "");
    };
    table.rows.push_back({escape_xml(format_key(finding.column)), describe(paper), describe(isotonic)});
  }
  return table;
}

// Where both rules have the same verdicts. A column without a level free of artifacts has its verdict before
// the material experiment.
std::string describe_agreement(const Report& report) {
  const std::size_t waiting = count_verdicts(report, Verdict::kUntested), all = report.findings.size();
  if (count_answers(report.material) > 0 || waiting == 0)
    return "<p>Both rules find the same equivalent levels in every column.</p>\n";
  if (waiting == all) return "<p>No material session is finished: neither rule has a verdict yet.</p>\n";
  return fmt::format(
      "<p>No material session is finished: of {} columns {} {} for its answers, and neither rule has a "
      "verdict there yet. In the others no level is left free of artifacts under either rule.</p>\n",
      all, waiting, choose_form(waiting, "waits", "wait"));
}

// By what rule levels went on to the material experiment.
std::string describe_choice(const Report& report) {
  std::set<std::string> rules;
  for (const FolderSelection& selection : report.selections) rules.insert(selection.rule);
  if (rules.size() > 1) return "in each folder by its own rule";
  if (report.selection && !report.selection->rule.empty()) rules.insert(report.selection->rule);
  return rules.empty() ? "by one rule" : fmt::format("by one rule (<i>{}</i>)", escape_xml(*rules.begin()));
}

}  // namespace

std::string format_banner(const Report& report) {
  if (report.evidence.kind == SubjectKind::kPlanted) {
    return R"(<div class="banner" role="note"><strong>These answers are planted. They tell nothing about these pictures.</strong>
No person and no program looked at them: simulated subjects answered by thresholds that were put in. This page shows only that the way from answers to tables works.</div>)";
  }
  if (report.evidence.kind == SubjectKind::kLooking) {
    return R"(<div class="banner" role="note"><strong>These answers are simulated from the pixels.</strong>
No person looked at the pictures: a model of vision answered. What persons would say has still to be asked.</div>)";
  }
  return "";
}

std::string format_warnings(const Report& report) {
  if (report.warnings.empty()) return "";
  std::string text = R"(<div class="warning" role="note"><b>Read this first</b><ul>)";
  for (const std::string& warning : report.warnings) text += "<li>" + escape_xml(warning) + "</li>\n";
  return text + "</ul></div>\n";
}

std::string format_summary(const Report& report) {
  const auto supported = std::count_if(
      report.findings.begin(), report.findings.end(),
      [&](const ColumnFinding& finding) { return !finding.under(report.rule).supported.empty(); });
  std::string text = fmt::format(
      "Under the rule <i>{}</i> some clamp level is not shown to be different from the reference in {} of {} "
      "columns "
      "(an object at a VPL count); in {} there is no such level. &ldquo;Equivalent&rdquo; means just that on "
      "this page. In {} of these columns a level is supported: there both proportions correct are shown to "
      "lie below 75&nbsp;%.",
      format_rule(report.rule), count_verdicts(report, Verdict::kExists), report.findings.size(),
      count_verdicts(report, Verdict::kNone), supported);
  if (const std::size_t unasked = count_unasked(report); unasked > 0) {
    text += fmt::format(
        " In {} of the columns without one nobody was asked about the material: no level was left to ask "
        "about.",
        unasked);
  }
  if (const auto untested = count_verdicts(report, Verdict::kUntested); untested > 0) {
    text += fmt::format(" {} {} not tested to the end.", untested, untested == 1 ? "is" : "are");
  }
  if (const auto dropped = count_dropped(report); dropped > 0) {
    text += fmt::format(
        " Of these {} {} dropped by pruning although under this rule levels are free of artifacts: nobody "
        "was "
        "asked about their material.",
        dropped, dropped == 1 ? "was" : "were");
  }
  return text;
}

std::string format_ee_squares(const Report& report) {
  std::string text;
  for (const Illumination illumination : enumerate_illuminations(report.study)) {
    std::vector<std::string> counts;
    for (const auto count : enumerate_vpl_counts(report.study, illumination)) {
      counts.push_back(format_vpl_count(count));
    }
    const std::string caption = fmt::format("{}; one square for each VPL count: {}",
                                            describe_illumination(illumination), fmt::join(counts, ", "));
    text += format_object_grid(report, illumination, "ee", caption, format_object_squares);
  }
  return text +
         R"(<p class="note"><span class="square exists">+</span>some clamp level is not shown to be different (equivalent)
<span class="square none">&minus;</span>no level is equivalent <span class="square untested">?</span>not tested
<span class="square exists supported">+</span>supported: at some green level both experiments were tested and both
proportions are shown, each at 95&nbsp;% one-sided, to lie below 75&nbsp;%.</p>)";
}

std::string format_graphs(const Report& report) {
  std::string text;
  for (const Illumination illumination : enumerate_illuminations(report.study)) {
    text += format_object_grid(report, illumination, "graphs", describe_illumination(illumination),
                               format_object_graph);
  }
  return text;
}

std::string format_monotone(const Report& report) {
  const Table reversed =
      collect_columns(report, [](const Threshold& threshold) { return !threshold.flags_monotone; });
  const Table uneven = collect_columns(
      report, [](const Threshold& threshold) { return threshold.flags_monotone && !threshold.monotone; });
  std::string text =
      reversed.rows.empty()
          ? fmt::format(
                "<p>In no column do the flags go back and forth: the rules agree on every {}cut.</p>\n",
                count_answers(report.material) > 0 ? "" : "artifact ")
          : "<p>In these the flags themselves go back and forth, so that the rule decides:</p>\n" +
                format_html_table(reversed, 99);
  if (!uneven.rows.empty()) {
    text += fmt::format(
        "<details><summary>{} in which only the proportions go back and forth; both rules give the same "
        "cut</summary>\n{}</details>\n",
        uneven.rows.size(), format_html_table(uneven, 99));
  }
  return text;
}

std::string format_rule_differences(const Report& report) {
  const Table verdicts = collect_verdict_differences(report);
  const Table untested = collect_untested(report);
  const std::string text =
      verdicts.rows.empty() ? describe_agreement(report) : format_html_table(verdicts, 99);
  if (untested.rows.empty()) return text;
  return text + fmt::format(
                    "<p>The levels of the material experiment were chosen {}. These levels, which a rule "
                    "would have kept, were not tested:</p>\n{}",
                    describe_choice(report), format_html_table(untested, 99));
}

}  // namespace equilux
