// Of planted answers: the thresholds that were put in beside those that came out.
#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "analysis/markup.h"
#include "analysis/page_sections.h"
#include "analysis/report_tables.h"

namespace equilux {
namespace {

// A cut as planted, as it would come out if all saw just what was planted at the levels that were tested, and
// as it did come out. Places on the scale; beyond it: no level.
struct Recovered {
  int planted = 0;
  Threshold best;
  Threshold found;
  int none = 0;  // the place beyond the scale

  bool is_tested() const { return found.status != CutStatus::kUntested; }
  // In levels; a cut below the tested ones is taken for the level before them.
  int find_distance() const { return std::abs(place_of(best) - place_of(found)); }

 private:
  int place_of(const Threshold& threshold) const {
    return threshold.cut.value_or(threshold.below ? *threshold.below - 1 : none);
  }
};

struct Recoveries {
  std::size_t tested = 0, exact = 0, near = 0;

  void add(const Recovered& one) {
    tested += one.is_tested() ? 1 : 0;
    exact += one.is_tested() && one.find_distance() == 0 ? 1 : 0;
    near += one.is_tested() && one.find_distance() <= 1 ? 1 : 0;
  }
};

Recovered recover_artifact(const ColumnFinding& finding, const PlantedColumn& planted, Rule rule) {
  ColumnCounts counts = finding.artifact;
  for (LevelCount& level : counts)
    level.count.k = level.level < planted.artifact_free_from ? level.count.n : 0;
  return {planted.artifact_free_from, find_cut(counts, Experiment::kArtifact, rule),
          finding.under(rule).artifact, kClampLevelCount};
}

Recovered recover_material(const ColumnFinding& finding, const PlantedColumn& planted, Rule rule) {
  ColumnCounts counts = finding.material;
  for (LevelCount& level : counts) level.count.k = level.level > planted.material_same_to ? level.count.n : 0;
  return {planted.material_same_to, find_cut(counts, Experiment::kMaterial, rule),
          finding.under(rule).material, -1};
}

std::string format_cut_or_none(const Threshold& threshold) {
  const std::string cut = format_cut(threshold);
  return cut == "-" ? "none" : escape_xml(cut);
}

std::string format_found(const Recovered& one) {
  if (!one.is_tested()) return "not tested";
  const std::string found = format_cut_or_none(one.found), best = format_cut_or_none(one.best);
  return found == best ? found : fmt::format("<b>{}</b> for {}", found, best);
}

bool has_own_truth(const Report& report) {
  for (const ExperimentEvidence* evidence : {&report.evidence.artifact, &report.evidence.material}) {
    for (const SessionRow& row : evidence->finished) {
      if (row.digests.truth != report.truth->digest) return false;
    }
  }
  return true;
}

// A level between those of the study may be equivalent too: nobody can be asked about it.
bool has_equivalent_level(const PlantedColumn& planted, const Study& study) {
  return std::any_of(study.clamp_levels.begin(), study.clamp_levels.end(),
                     [&](int level) { return is_equivalent(planted, level); });
}

const char* format_exists(bool exists) { return exists ? "+" : "&minus;"; }

const char* format_found_verdict(Verdict verdict) {
  return verdict == Verdict::kUntested ? "?" : format_exists(verdict == Verdict::kExists);
}

std::string describe_recoveries(const Recoveries& sum, const std::string& experiment) {
  return fmt::format("{} cuts: {} of {} as perfect answers would give them, {} within one level. ",
                     experiment, sum.exact, sum.tested, sum.near);
}

std::string format_recoveries(const Report& report) {
  Table table{{"column", "artifact-free from, planted", "found", "same material to, planted", "found",
               "EE, planted", "found"},
              {}};
  Recoveries artifact, material;
  std::size_t verdicts = 0, right = 0;
  for (const ColumnFinding& finding : report.findings) {
    const PlantedColumn& planted = report.truth->by_column.at(finding.column);
    const RuleFinding& under = finding.under(report.rule);
    const Recovered free_from = recover_artifact(finding, planted, report.rule),
                    same_to = recover_material(finding, planted, report.rule);
    const bool exists = has_equivalent_level(planted, report.study);
    artifact.add(free_from);
    material.add(same_to);
    verdicts += under.verdict != Verdict::kUntested ? 1 : 0;
    right += under.verdict == (exists ? Verdict::kExists : Verdict::kNone) ? 1 : 0;
    table.rows.push_back({escape_xml(format_key(finding.column)),
                          format_place(free_from.planted, report.study), format_found(free_from),
                          format_place(same_to.planted, report.study), format_found(same_to),
                          format_exists(exists), format_found_verdict(under.verdict)});
  }
  return fmt::format(
             "<p>{}{}EE: {} of {} as planted. Perfect answers, of subjects who see just what "
             "was planted, give another cut than the planted one where that lies between or beyond the "
             "levels "
             "tested; where the found cut differs from theirs, it is in bold.</p>\n",
             describe_recoveries(artifact, "Artifact"), describe_recoveries(material, "Material"), right,
             verdicts) +
         format_html_table(table, 99) +
         fmt::format(
             "<p class=\"note\">Planted: <code>truth.json</code>, lapses {:g}, side bias {:g}. Found: by the "
             "rule <i>{}</i>, in <code>thresholds.csv</code> and <code>ee.csv</code>.</p>\n",
             report.truth->lapse_rate, report.truth->side_bias, format_rule(report.rule));
}

}  // namespace

std::string format_recovery(const Report& report) {
  if (report.evidence.kind != SubjectKind::kPlanted || !report.truth) return "";
  return "<section>\n<h2>What was planted, and what was found</h2>\n" +
         (has_own_truth(report) ? format_recoveries(report)
                                : "<p>Some sessions were planted by another truth than the folder&rsquo;s "
                                  "<code>truth.json</code>: nothing is compared.</p>\n") +
         "</section>\n";
}

}  // namespace equilux
