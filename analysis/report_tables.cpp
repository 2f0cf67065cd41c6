// Reports to rows and to JSON; nothing is computed here that a stage before has not found.
#include "analysis/report_tables.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <set>

#include "analysis/order_draws.h"
#include "analysis/participation.h"
#include "analysis/tables.h"
#include "analysis/trend_bounds.h"
#include "analysis/views.h"
#include "base/error.h"
#include "base/version.h"

namespace equilux {
namespace {

using Row = std::vector<std::string>;

std::string format_bool(bool value) { return value ? "true" : "false"; }

std::string format_int(std::int64_t value) { return fmt::format("{}", value); }

void append(Row& row, const Row& more) { row.insert(row.end(), more.begin(), more.end()); }

// The study's name and whose answers it has before every row, more columns behind it.
Table widen(Table table, const Report& report, const Row& columns, const std::vector<Row>& more) {
  EQ_CHECK(columns.empty() || more.size() == table.rows.size(), more.size(), table.rows.size());
  const Row first{report.study.name, format_kind(report.evidence.kind)};
  table.columns.insert(table.columns.begin(), {"study", "kind"});
  append(table.columns, columns);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    table.rows[i].insert(table.rows[i].begin(), first.begin(), first.end());
    if (!columns.empty()) append(table.rows[i], more[i]);
  }
  return table;
}

Row estimate_fields(const CellStatistics& cell) {
  Row row{format_cell_status(cell.status)};
  if (!cell.estimate) {
    row.resize(7);
    return row;
  }
  const CellEstimate& e = *cell.estimate;
  for (const double value : {e.clopper_pearson.lower, e.clopper_pearson.upper, e.jeffreys.lower,
                             e.jeffreys.upper, e.q_guess, e.posterior_over}) {
    row.push_back(format_number(value));
  }
  return row;
}

Table make_cells(const Report& report) {
  std::vector<Row> more;
  for (const auto* cells : {&report.artifact_cells, &report.material_cells}) {
    for (const Cell& cell : enumerate_cells(report.study)) more.push_back(estimate_fields(cells->at(cell)));
  }
  return widen(
      make_cells_table(report.study, report.artifact, report.material), report,
      {"status", "cp_lower", "cp_upper", "jeffreys_lower", "jeffreys_upper", "q_guess", "posterior_over"},
      more);
}

Row range_fields(const std::optional<CutRange>& range, const Study& study) {
  if (!range) return {"", ""};
  return {format_place(range->lower, study), format_place(range->upper, study)};
}

// In the order of make_thresholds_table.
Table make_thresholds(const Report& report) {
  std::vector<Row> more;
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    for (const ColumnUncertainty& column : report.uncertainty.columns) {
      for (const Rule rule : kRules) {
        const RuleUncertainty& under = column.under(rule);
        more.push_back(range_fields(
            experiment == Experiment::kArtifact ? under.artifact_cut : under.material_cut, report.study));
      }
    }
  }
  return widen(make_thresholds_table(report.findings), report, {"cut_lower", "cut_upper"}, more);
}

Row uncertainty_fields(const Report& report, std::size_t c) {
  const ColumnUncertainty& column = report.uncertainty.columns[c];
  Row row;
  for (const Rule rule : kRules) {
    const RuleUncertainty& under = column.under(rule);
    append(row, {format_uncertainty_status(under.status), format_number(under.posterior),
                 format_number(under.posterior_above_half), format_number(under.bootstrap),
                 is_resampled(under.status)
                     ? format_int(std::ssize(under.artifact_flips) + std::ssize(under.material_flips))
                     : ""});
    for (const auto& findings : report.at_other_percents)
      row.push_back(format_verdict(findings[c].under(rule).verdict));
    append(row, {format_number(under.free_posterior), format_number(under.free_bootstrap),
                 under.free_bootstrap ? format_int(std::ssize(under.free_flips)) : ""});
  }
  return row;
}

Table make_ee(const Report& report) {
  Row columns;
  for (const Rule rule : kRules) {
    for (const char* name : {"uncertainty", "posterior", "posterior_above_half", "bootstrap", "flips", "ee70",
                             "ee80", "free_posterior", "free_bootstrap", "free_flips"})
      columns.push_back(fmt::format("{}_{}", name, format_rule(rule)));
  }
  std::vector<Row> more;
  for (std::size_t c = 0; c < report.findings.size(); ++c) more.push_back(uncertainty_fields(report, c));
  return widen(make_ee_table(report.findings), report, columns, more);
}

// Whether the person who stands by this session turns the column: its verdict, or, without candidates,
// whether some level is free of artifacts.
bool is_turned_by(const RuleUncertainty& under, Experiment experiment, std::int64_t session) {
  const bool is_artifact = experiment == Experiment::kArtifact;
  const auto names = [&](const std::vector<std::int64_t>& flips) {
    return std::binary_search(flips.begin(), flips.end(), session);
  };
  return names(is_artifact ? under.artifact_flips : under.material_flips) ||
         (is_artifact && under.free_bootstrap && names(under.free_flips));
}

std::string format_turned(const Report& report, Experiment experiment, std::int64_t session, Rule rule) {
  std::vector<std::string> keys;
  for (std::size_t c = 0; c < report.findings.size(); ++c) {
    if (is_turned_by(report.uncertainty.columns[c].under(rule), experiment, session))
      keys.push_back(format_key(report.findings[c].column));
  }
  return fmt::format("{}", fmt::join(keys, " "));
}

Row subject_row(const Report& report, Experiment experiment, const SubjectFinding& finding) {
  const SessionSummary& s = finding.summary;
  return {report.study.name,
          format_kind(report.evidence.kind),
          format_experiment(experiment),
          format_int(s.session),
          s.participant,
          s.folder,
          format_int(s.subject_index),
          format_bool(s.complete),
          format_int(s.scheduled),
          format_int(s.answered),
          format_int(s.first_half.k + s.second_half.k),
          format_int(s.left),
          format_number(finding.p_side),
          format_number(s.median_response_s),
          format_int(s.too_fast),
          format_int(s.caught.k),
          format_int(s.caught.n),
          s.catch_pass ? format_int(*s.catch_pass) : "",
          format_number(finding.agreement),
          format_marks(finding.marks),
          s.abort_reason.value_or(""),
          s.language,
          format_turned(report, experiment, s.session, Rule::kPaper),
          format_turned(report, experiment, s.session, Rule::kIsotonic)};
}

const SubjectsReport& subjects_of(const Report& report, Experiment experiment) {
  return experiment == Experiment::kArtifact ? report.artifact_subjects : report.material_subjects;
}

Table make_subjects(const std::vector<Report>& reports) {
  Table table{
      {"study",         "kind",     "experiment",   "session",       "participant",    "folder",
       "subject_index", "complete", "scheduled",    "answered",      "correct",        "left",
       "p_side",        "median_s", "too_fast",     "catch_correct", "catch_answered", "catch_pass",
       "agreement",     "marks",    "abort_reason", "language",      "turns_paper",    "turns_isotonic"},
      {}};
  for (const Report& report : reports) {
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      for (const SubjectFinding& finding : subjects_of(report, experiment).sessions)
        table.rows.push_back(subject_row(report, experiment, finding));
    }
  }
  return table;
}

Row interval_fields(const std::optional<Interval>& interval) {
  if (!interval) return {"", ""};
  return {format_number(interval->lower), format_number(interval->upper)};
}

Table make_order(const std::vector<Report>& reports) {
  Table table{{"study", "kind", "experiment", "subjects", "correct", "lower", "upper", "p", "speed"}, {}};
  for (const Report& report : reports) {
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      const OrderEffect& order = subjects_of(report, experiment).order;
      Row row{report.study.name, format_kind(report.evidence.kind), format_experiment(experiment),
              format_int(static_cast<std::int64_t>(order.subjects)), format_number(order.correct)};
      append(row, interval_fields(order.interval));
      append(row, {format_number(order.p), format_number(order.speed)});
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

Row trend_row(const Report& report, const Trend& trend, double least_holm) {
  Row row{report.study.name,
          format_kind(report.evidence.kind),
          format_rule(report.rule),
          trend.factor,
          trend.from,
          trend.to,
          format_trend_status(trend.status),
          format_int(trend.strata),
          format_int(trend.pairs),
          format_int(trend.clusters),
          format_int(trend.gained),
          format_int(trend.lost),
          format_number(trend.effect)};
  append(row, interval_fields(trend.interval));
  append(row, {format_number(trend.p), format_number(trend.p_least), format_number(trend.p_holm),
               format_number(least_holm), format_bool(trend.holds), describe_trend(trend)});
  return row;
}

Table make_trends(const std::vector<Report>& reports) {
  Table table{{"study",  "kind",  "rule",     "factor", "from",         "to",     "status",
               "strata", "pairs", "clusters", "gained", "lost",         "effect", "lower",
               "upper",  "p",     "p_least",  "p_holm", "p_least_holm", "holds",  "sentence"},
              {}};
  for (const Report& report : reports) {
    const std::vector<double> least = find_least_holm(report.trends);
    for (std::size_t i = 0; i < report.trends.size(); ++i)
      table.rows.push_back(trend_row(report, report.trends[i], least[i]));
  }
  return table;
}

template <typename Make>
Table stack(const std::vector<Report>& reports, const Make& make) {
  Table all;
  for (const Report& report : reports) {
    Table table = make(report);
    all.columns = table.columns;
    all.rows.insert(all.rows.end(), table.rows.begin(), table.rows.end());
  }
  return all;
}

Json make_value(const std::string& text, std::string_view datatype) {
  if (datatype == "string") return text;
  if (text.empty()) return nullptr;
  if (datatype == "boolean") return text == "true";
  if (datatype == "integer") return std::stoll(text);
  return std::strtod(text.c_str(), nullptr);  // std::stod throws at what is below the least normal number
}

// What finished sessions say of one thing, each value once, sorted; not where they say nothing.
Json make_values_json(const ExperimentEvidence& evidence, const auto& value_of) {
  std::set<std::string> values;
  for (const SessionRow& row : evidence.finished) values.insert(value_of(row));
  values.erase("");
  return make_json(std::vector<std::string>(values.begin(), values.end()));
}

Json make_spread_json(const Spread& spread) {
  Json json;
  json.set("measured", spread.measured).set("largest_difference", spread.largest);
  return json.set("over", spread.over);
}

Json make_balance_json(const Balance& balance) {
  Json json;
  json.set("sessions", make_spread_json(balance.sessions)).set("cells", make_spread_json(balance.cells));
  json.set("allowed_difference", kBalanceAllows);
  return json.set("most_answers_of_a_subject_to_a_cell", balance.most_answers);
}

// Correct and answered, view by view; null where views are not known.
Json make_views_json(const ExperimentEvidence& evidence) {
  const auto views = count_by_view(evidence);
  if (!views) return nullptr;
  Json json;
  for (std::size_t view = 0; view < views->size(); ++view) {
    Json of_view;
    of_view.set("k", (*views)[view].k).set("n", (*views)[view].n);
    json.set(fmt::format("v{}", view), std::move(of_view));
  }
  return json;
}

Json make_experiment_json(const Report& report, Experiment experiment) {
  const bool is_artifact = experiment == Experiment::kArtifact;
  const ExperimentEvidence& evidence = report.evidence.of(experiment);
  const Balance& balance = is_artifact ? report.artifact_balance : report.material_balance;
  Json json;
  json.set("finished_sessions", evidence.finished.size()).set("unfinished_sessions", evidence.unfinished);
  json.set("ended_early_sessions", count_ended_early(evidence));
  json.set("participants", count_participants(evidence));
  json.set("answers", evidence.answers.size()).set("answers_digest", evidence.digest);
  const auto add = [&](const char* name, std::string SessionDigests::*member) {
    json.set(name, make_values_json(evidence, [&](const SessionRow& row) { return row.digests.*member; }));
  };
  add("pictures_digests", &SessionDigests::manifest);
  add("windows_digests", &SessionDigests::windows);
  add("selection_digests", &SessionDigests::selection);
  add("truth_digests", &SessionDigests::truth);
  add("protocol_digests", &SessionDigests::protocol);
  json.set("session_programs",
           make_values_json(evidence, [](const SessionRow& row) { return row.program_version; }));
  json.set("balance", make_balance_json(balance)).set("by_view", make_views_json(evidence));
  json.set("prior_cut_off_adds_at_most",
           find_most_by_truncation(is_artifact ? report.artifact : report.material));
  json.set("participation", make_participation_json(find_participation(evidence)));
  return json.set("session_seeds", make_values_json(evidence, [](const SessionRow& row) {
                    return fmt::format("{}", row.seed);
                  }));
}

Json make_selections_json(const std::vector<FolderSelection>& selections) {
  Json rows{Json::Array{}};
  for (const FolderSelection& selection : selections) {
    Json row;
    row.set("folder", selection.folder).set("rule", selection.rule).set("digest", selection.digest);
    rows.push(std::move(row.set("answers_digest", selection.answers_digest)));
  }
  return rows;
}

Json make_study_json(const Report& report) {
  Json json;
  json.set("name", report.study.name).set("digest", report.study.digest);
  json.set("kind", format_kind(report.evidence.kind)).set("rule", format_rule(report.rule));
  json.set("folders", make_json(report.folders)).set("warnings", make_json(report.warnings));
  json.set("artifact", make_experiment_json(report, Experiment::kArtifact));
  json.set("material", make_experiment_json(report, Experiment::kMaterial));
  json.set("withdrawn", report.evidence.withdrawn);
  std::vector<std::string> flipped;
  for (const Column& column : report.flipped_without_marked) flipped.push_back(format_key(column));
  json.set("flipped_without_marked", make_json(flipped));
  if (report.selection && report.selections.empty())
    json.set("selection_digest", digest_selection(*report.selection));
  if (!report.selections.empty()) json.set("selections", make_selections_json(report.selections));
  if (report.windows) json.set("windows_digest", report.windows->digest);
  if (report.manifest) json.set("rendering_seed", report.manifest->seed);
  return json;
}

}  // namespace

std::vector<ReportTable> make_report_tables(const std::vector<Report>& reports) {
  return {{"cells.csv", stack(reports, make_cells)}, {"thresholds.csv", stack(reports, make_thresholds)},
          {"ee.csv", stack(reports, make_ee)},       {"subjects.csv", make_subjects(reports)},
          {"order.csv", make_order(reports)},        {"trends.csv", make_trends(reports)}};
}

Json make_rows_json(const ReportTable& table) {
  std::vector<const DictionaryEntry*> entries;
  for (const std::string& column : table.table.columns) entries.push_back(&find_entry(table.file, column));
  Json rows{Json::Array{}};
  for (const Row& row : table.table.rows) {
    Json object;
    for (std::size_t i = 0; i < row.size(); ++i)
      object.set(table.table.columns[i], make_value(row[i], entries[i]->datatype));
    rows.push(std::move(object));
  }
  return rows;
}

Json make_report_json(const std::vector<Report>& reports) {
  Json json;
  json.set("schema", "equilux-report")
      .set("schema_version", 1)
      .set("producer", std::string("equilux-analyze ") + kVersion);
  const UncertaintyParams& params = reports.front().params;
  json.set("seed", params.seed)
      .set("posterior_draws", params.posterior_draws)
      .set("resamples", params.resamples)
      .set("order_draws", kOrderDraws)
      .set("order_streams", make_json({kOrderFlipStream, kOrderBootstrapStream}));
  json.set("flag_percent", kFlagPercent).set("interval_level", kIntervalLevel);
  json.set("support_level", kSupportLevel).set("trend_level", kTrendLevel);
  Json studies{Json::Array{}};
  for (const Report& report : reports) studies.push(make_study_json(report));
  json.set("studies", std::move(studies));
  for (const ReportTable& table : make_report_tables(reports))
    json.set(table.file.substr(0, table.file.size() - 4), make_rows_json(table));
  return json;
}

std::string format_place(int place, const Study& study) {
  const bool inside = place >= study.clamp_levels.front() && place <= study.clamp_levels.back();
  return inside ? format_clamp(place) : "none";
}

}  // namespace equilux
