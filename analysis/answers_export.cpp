// Answers to rows.
#include "analysis/answers_export.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <tuple>

namespace equilux {
namespace {

using Row = std::vector<std::string>;

Row answer_row(const std::string& study, SubjectKind kind, Experiment experiment,
               const std::string& participant, const CountedAnswer& answer, const Cell& cell) {
  const Object& object = cell.column.object;
  return {study,
          format_kind(kind),
          format_experiment(experiment),
          fmt::format("{}", answer.session),
          participant,
          object.geometry,
          object.material,
          format_illumination(object.illumination),
          fmt::format("{}", cell.column.vpl_count),
          format_clamp(cell.clamp_level, cell.normalised),
          fmt::format("{}", cell.clamp_level),
          answer.correct ? "1" : "0"};
}

void add_rows(Table& table, const Report& report, Experiment experiment) {
  const ExperimentEvidence& evidence = report.evidence.of(experiment);
  std::map<std::int64_t, std::string> participants;
  for (const SessionRow& session : evidence.finished) participants[session.id] = session.participant;
  std::vector<CountedAnswer> sorted = evidence.answers.rows();
  std::sort(sorted.begin(), sorted.end(), [&](const CountedAnswer& a, const CountedAnswer& b) {
    return std::tie(a.session, evidence.answers.cell_of(a)) <
           std::tie(b.session, evidence.answers.cell_of(b));
  });
  for (const CountedAnswer& answer : sorted)
    table.rows.push_back(answer_row(report.study.name, report.evidence.kind, experiment,
                                    participants[answer.session], answer, evidence.answers.cell_of(answer)));
}

}  // namespace

Table make_answers_table(const std::vector<Report>& reports) {
  Table table{{"study", "kind", "experiment", "session", "participant", "geometry", "material",
               "illumination", "vpls", "clamp", "clamp_level", "correct"},
              {}};
  for (const Report& report : reports) {
    add_rows(table, report, Experiment::kArtifact);
    add_rows(table, report, Experiment::kMaterial);
  }
  return table;
}

}  // namespace equilux
