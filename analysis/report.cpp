// Evidence to a report, and a report to its files.
#include "analysis/report.h"

#include <algorithm>
#include <future>
#include <map>
#include <tuple>
#include <utility>

#include "analysis/graph.h"
#include "analysis/report_tables.h"
#include "analysis/tables.h"
#include "analysis/warnings.h"
#include "base/error.h"

namespace equilux {
namespace {

// What the two give. An error of the first goes before one of the second.
auto both_at_once(const auto& first, const auto& second) {
  auto beside = std::async(std::launch::async, second);
  auto one = first();
  return std::pair(std::move(one), beside.get());
}

std::vector<std::int64_t> find_marked(const SubjectsReport& subjects) {
  std::vector<std::int64_t> marked;
  for (const SubjectFinding& finding : subjects.sessions) {
    if (!finding.marks.empty()) marked.push_back(finding.summary.session);
  }
  std::sort(marked.begin(), marked.end());
  return marked;
}

SubjectsReport report_subjects(ExperimentEvidence& evidence, const ResponseMatrix& matrix,
                               std::uint64_t seed) {
  auto& summaries = evidence.summaries;
  std::sort(summaries.begin(), summaries.end(), [](const SessionSummary& a, const SessionSummary& b) {
    return std::tie(a.folder, a.subject_index, a.session) < std::tie(b.folder, b.subject_index, b.session);
  });
  return {find_subjects(summaries, matrix), find_order_effect(summaries, seed)};
}

// Verdicts without the sessions that are marked, against those with all.
std::vector<Column> find_flipped_without_marked(const Report& report) {
  const auto artifact = find_marked(report.artifact_subjects),
             material = find_marked(report.material_subjects);
  if (artifact.empty() && material.empty()) return {};
  const auto without = [&](const Tally& all, const ExperimentEvidence& evidence,
                           const std::vector<std::int64_t>& marked) {
    Tally rest = all;
    for (const auto& [cell, count] : tally_answers(select_answers(evidence, marked), report.study)) {
      rest[cell].k -= count.k;
      rest[cell].n -= count.n;
    }
    return rest;
  };
  const auto rest =
      find_equivalence(report.study, without(report.artifact, report.evidence.artifact, artifact),
                       without(report.material, report.evidence.material, material),
                       report.selection ? &*report.selection : nullptr);
  std::vector<Column> flipped;
  for (std::size_t c = 0; c < rest.size(); ++c) {
    if (rest[c].under(report.rule).verdict != report.findings[c].under(report.rule).verdict)
      flipped.push_back(rest[c].column);
  }
  return flipped;
}

std::map<std::int64_t, std::string> find_codes(const ExperimentEvidence& evidence) {
  std::map<std::int64_t, std::string> codes;
  for (const SessionRow& row : evidence.finished) codes[row.id] = row.participant;
  return codes;
}

void add_uncertainty(Report& report) {
  const auto matrices = both_at_once([&] { return make_response_matrix(report.evidence.artifact.answers); },
                                     [&] { return make_response_matrix(report.evidence.material.answers); });
  const ResponseMatrix &seen = matrices.first, &changed = matrices.second;
  const Selection* selection = report.selection ? &*report.selection : nullptr;
  // Beside the rest, which is as long and reads other things.
  std::future<Uncertainty> uncertainty = std::async(std::launch::async, [&] {
    return find_uncertainty(report.study, report.findings,
                            group_by_person(seen, find_codes(report.evidence.artifact)),
                            group_by_person(changed, find_codes(report.evidence.material)), report.params);
  });
  report.artifact_cells = find_cell_statistics(report.artifact);
  report.material_cells = find_cell_statistics(report.material);
  for (std::size_t i = 0; i < kOtherPercents.size(); ++i) {
    report.at_other_percents[i] =
        find_equivalence(report.study, report.artifact, report.material, selection, kOtherPercents[i]);
  }
  report.artifact_subjects = report_subjects(report.evidence.artifact, seen, report.params.seed);
  report.material_subjects = report_subjects(report.evidence.material, changed, report.params.seed);
  report.uncertainty = uncertainty.get();
  report.trends = find_trends(report.study, report.findings, report.rule, report.uncertainty);
  report.flipped_without_marked = find_flipped_without_marked(report);
}

ReportFiles make_table_files(const std::vector<Report>& reports) {
  ReportFiles files;
  const auto tables = make_report_tables(reports);
  for (const ReportTable& table : tables) files[table.file] = format_csv(table.table);
  files["csv-metadata.json"] = format_json(make_csv_metadata(tables));
  files["report.json"] = format_json(make_report_json(reports));
  return files;
}

ReportFiles make_page_files(const std::vector<Report>& reports) {
  ReportFiles files;
  for (const Report& report : reports) {
    const std::string study = reports.size() > 1 ? report.study.name + "-" : "";
    for (const Object& object : enumerate_objects(report.study)) {
      files[fmt::format("graph-{}{}.svg", study, format_key(object))] = draw_lone_graph(
          object, findings_of(report.findings, object), report.rule, report.study.name, report.evidence.kind);
    }
  }
  files[kReportPage] = format_page(reports);
  return files;
}

}  // namespace

Report make_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources,
                   const UncertaintyParams& params) {
  const auto warnings = find_source_warnings(study, evidence, sources);
  return make_pooled_report(study, std::move(evidence), rule, std::move(sources), params, warnings);
}

Report make_pooled_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources,
                          const UncertaintyParams& params, const std::vector<std::string>& warnings) {
  Report report;
  report.study = study;
  report.evidence = std::move(evidence);
  report.rule = rule;
  report.params = params;
  std::tie(report.artifact, report.material) =
      both_at_once([&] { return tally_answers(report.evidence.artifact.answers, study); },
                   [&] { return tally_answers(report.evidence.material.answers, study); });
  report.selection = std::move(sources.selection);
  report.selections = std::move(sources.selections);
  report.windows = std::move(sources.windows);
  report.manifest = std::move(sources.manifest);
  report.convergences = std::move(sources.convergences);
  report.protocol = std::move(sources.protocol);
  report.truth = std::move(sources.truth);
  report.artifact_prompts = std::move(sources.artifact_prompts);
  report.material_prompts = std::move(sources.material_prompts);
  report.findings = find_equivalence(study, report.artifact, report.material,
                                     report.selection ? &*report.selection : nullptr);
  std::tie(report.artifact_balance, report.material_balance) =
      both_at_once([&] { return find_balance(report.evidence.artifact); },
                   [&] { return find_balance(report.evidence.material); });
  add_uncertainty(report);
  report.warnings = warnings;
  for (std::string& warning : find_answer_warnings(report)) report.warnings.push_back(std::move(warning));
  return report;
}

void sort_reports(std::vector<Report>& reports) {
  std::sort(reports.begin(), reports.end(), [](const Report& a, const Report& b) {
    if (a.findings.size() != b.findings.size()) return a.findings.size() > b.findings.size();
    return a.study.name < b.study.name;
  });
  for (std::size_t i = 1; i < reports.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (reports[i].study.name == reports[j].study.name)
        throw InputError(reports[i].study.name, "", "studies of one name to be one study",
                         "two with different digests");
    }
  }
}

void add_normalisation_trends(std::vector<Report>& reports) {
  for (Report& normalised : reports) {
    if (!normalised.study.normalise) continue;
    for (const Report& plain : reports) {
      if (plain.study.normalise) continue;
      const Trend trend = compare_studies(
          {plain.study.name, plain.findings, plain.uncertainty},
          {normalised.study.name, normalised.findings, normalised.uncertainty}, normalised.rule);
      if (trend.status != TrendStatus::kNoPairs) normalised.trends.push_back(trend);
    }
    adjust_trends(normalised.trends);
  }
}

ReportFiles make_report_files(const std::vector<Report>& reports) {
  auto [files, page] =
      both_at_once([&] { return make_table_files(reports); }, [&] { return make_page_files(reports); });
  files.merge(page);
  return files;
}

}  // namespace equilux
