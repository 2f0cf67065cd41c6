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
               const std::string& participant, const AnswerRow& answer) {
  const Object& object = answer.cell.column.object;
  return {study,
          format_kind(kind),
          format_experiment(experiment),
          fmt::format("{}", answer.session),
          participant,
          object.geometry,
          object.material,
          format_illumination(object.illumination),
          fmt::format("{}", answer.cell.column.vpl_count),
          format_clamp(answer.cell.clamp_level, answer.cell.normalised),
          fmt::format("{}", answer.cell.clamp_level),
          answer.correct ? "1" : "0"};
}

void add_rows(Table& table, const Report& report, Experiment experiment) {
  const ExperimentEvidence& evidence = report.evidence.of(experiment);
  std::map<std::int64_t, std::string> participants;
  for (const SessionRow& session : evidence.finished) participants[session.id] = session.participant;
  std::vector<const AnswerRow*> sorted;
  for (const AnswerRow& answer : evidence.answers) sorted.push_back(&answer);
  std::sort(sorted.begin(), sorted.end(), [](const AnswerRow* a, const AnswerRow* b) {
    return std::tie(a->session, a->cell) < std::tie(b->session, b->cell);
  });
  for (const AnswerRow* answer : sorted)
    table.rows.push_back(answer_row(report.study.name, report.evidence.kind, experiment,
                                    participants[answer->session], *answer));
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
