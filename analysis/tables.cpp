// Values to rows; nothing is computed here that a stage before has not found.
#include "analysis/tables.h"

#include <algorithm>
#include <fmt/format.h>

#include "analysis/probability.h"

namespace equilux {
namespace {

using Row = std::vector<std::string>;

template <typename T>
void add_once(std::vector<T>& values, const T& value) {
  if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

Row key_fields(const Column& column) {
  return {column.object.geometry, column.object.material, format_illumination(column.object.illumination),
          fmt::format("{}", column.vpl_count)};
}

Row join(Row row, const Row& more) {
  row.insert(row.end(), more.begin(), more.end());
  return row;
}

std::string format_flag(bool flag) { return flag ? "true" : "false"; }

std::string format_exists(Verdict verdict) {
  return verdict == Verdict::kUntested ? "" : format_flag(verdict == Verdict::kExists);
}

Row cell_row(Experiment experiment, const Cell& cell, const Count& count) {
  std::optional<double> proportion;
  if (count.n > 0) proportion = static_cast<double>(count.k) / static_cast<double>(count.n);
  return join(join({format_experiment(experiment)}, key_fields(cell.column)),
              {format_clamp(cell.clamp_level, cell.normalised), fmt::format("{}", count.k),
               fmt::format("{}", count.n), format_number(proportion), format_number(eval_p_guess(count))});
}

Row threshold_row(const ColumnFinding& column, Experiment experiment, Rule rule) {
  const bool is_artifact = experiment == Experiment::kArtifact;
  const RuleFinding& finding = column.under(rule);
  const Threshold& threshold = is_artifact ? finding.artifact : finding.material;
  std::vector<int> tested;
  for (const LevelCount& level : is_artifact ? column.artifact : column.material) {
    if (level.count.n > 0) tested.push_back(level.level);
  }
  return join(
      join({format_experiment(experiment)}, key_fields(column.column)),
      {format_rule(rule), threshold.cut ? format_clamp(*threshold.cut) : "", format_status(threshold.status),
       format_flag(threshold.monotone), format_flag(threshold.flags_monotone), format_levels(tested),
       is_artifact ? "" : format_levels(finding.untested)});
}

char mark_of(Verdict verdict) {
  return verdict == Verdict::kExists ? '+' : verdict == Verdict::kNone ? '-' : '?';
}

// One mark for each VPL count of the illumination; a dot where the study has no such column.
std::string format_marks(const std::vector<const ColumnFinding*>& columns,
                         const std::vector<std::int64_t>& vpl_counts, Rule rule) {
  std::string marks(vpl_counts.size(), '.');
  for (const ColumnFinding* column : columns) {
    const auto place = std::find(vpl_counts.begin(), vpl_counts.end(), column->column.vpl_count);
    marks[static_cast<std::size_t>(place - vpl_counts.begin())] = mark_of(column->under(rule).verdict);
  }
  return marks;
}

std::size_t longest(const std::vector<std::string>& words, std::size_t least) {
  for (const std::string& word : words) least = std::max(least, word.size());
  return least;
}

std::string join_line(const std::vector<std::string>& fields, std::size_t first_width, std::size_t width) {
  std::string line = fmt::format("  {:<{}}", fields.front(), first_width);
  for (std::size_t i = 1; i < fields.size(); ++i) line += fmt::format("  {:<{}}", fields[i], width);
  return line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
}

std::string format_ee_grid(const Study& study, const std::vector<ColumnFinding>& findings,
                           Illumination illumination, Rule rule) {
  const auto vpl_counts = enumerate_vpl_counts(study, illumination);
  const auto materials = enumerate_materials(study);
  const auto geometries = enumerate_geometries(study);
  const std::size_t first_width = longest(geometries, 0);
  const std::size_t width = longest(materials, vpl_counts.size());
  std::string text = join_line(join({""}, materials), first_width, width);
  for (const auto& geometry : geometries) {
    std::vector<std::string> fields{geometry};
    for (const auto& material : materials) {
      fields.push_back(
          format_marks(findings_of(findings, {geometry, material, illumination}), vpl_counts, rule));
    }
    text += join_line(fields, first_width, width);
  }
  return text;
}

}  // namespace

Table make_cells_table(const Study& study, const Tally& artifact, const Tally& material) {
  Table table{{"experiment", "geometry", "material", "illumination", "vpls", "clamp", "k", "n", "proportion",
               "p_guess"},
              {}};
  for (const Cell& cell : enumerate_cells(study)) {
    table.rows.push_back(cell_row(Experiment::kArtifact, cell, artifact.at(cell)));
  }
  for (const Cell& cell : enumerate_cells(study)) {
    table.rows.push_back(cell_row(Experiment::kMaterial, cell, material.at(cell)));
  }
  return table;
}

Table make_thresholds_table(const std::vector<ColumnFinding>& findings) {
  Table table{{"experiment", "geometry", "material", "illumination", "vpls", "rule", "cut", "status",
               "monotone", "flags_monotone", "tested", "untested"},
              {}};
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    for (const ColumnFinding& finding : findings) {
      for (const Rule rule : kRules) table.rows.push_back(threshold_row(finding, experiment, rule));
    }
  }
  return table;
}

Table make_ee_table(const std::vector<ColumnFinding>& findings) {
  Table table{{"geometry", "material", "illumination", "vpls", "ee_paper", "ee_isotonic"}, {}};
  for (const Rule rule : kRules) {
    for (const char* name : {"status", "green", "supported"}) {
      table.columns.push_back(fmt::format("{}_{}", name, format_rule(rule)));
    }
  }
  table.columns.push_back("dropped");
  for (const ColumnFinding& finding : findings) {
    Row row = key_fields(finding.column);
    for (const Rule rule : kRules) row.push_back(format_exists(finding.under(rule).verdict));
    for (const Rule rule : kRules) {
      const RuleFinding& under = finding.under(rule);
      row = join(row,
                 {format_verdict(under.verdict), format_levels(under.green), format_levels(under.supported)});
    }
    table.rows.push_back(join(row, {format_flag(finding.dropped)}));
  }
  return table;
}

std::string format_ee_text(const Study& study, const std::vector<ColumnFinding>& findings, Rule rule) {
  std::string text;
  for (const Illumination illumination : enumerate_illuminations(study)) {
    std::vector<std::string> counts;
    for (const auto count : enumerate_vpl_counts(study, illumination)) {
      counts.push_back(format_vpl_count(count));
    }
    text += fmt::format("Equivalence exists, {} (rule {}; marks: {} VPLs)\n",
                        describe_illumination(illumination), format_rule(rule), fmt::join(counts, ", "));
    text += format_ee_grid(study, findings, illumination, rule);
  }
  return text +
         "  + some clamp level is not shown to be different   - none is   ? not tested   . not in the "
         "study\n";
}

std::string format_levels(const std::vector<int>& levels) {
  std::string text;
  for (int level : levels) {
    if (!text.empty()) text += ' ';
    text += format_clamp(level);
  }
  return text;
}

std::string format_number(const std::optional<double>& value) {
  return value ? fmt::format("{}", *value) : "";
}

std::string format_verdict(Verdict verdict) {
  return verdict == Verdict::kExists ? "exists" : verdict == Verdict::kNone ? "none" : "untested";
}

std::vector<std::string> enumerate_geometries(const Study& study) {
  std::vector<std::string> geometries;
  for (const Object& object : enumerate_objects(study)) add_once(geometries, object.geometry);
  return geometries;
}

std::vector<std::string> enumerate_materials(const Study& study) {
  std::vector<std::string> materials;
  for (const Object& object : enumerate_objects(study)) add_once(materials, object.material);
  return materials;
}

std::vector<Illumination> enumerate_illuminations(const Study& study) {
  std::vector<Illumination> illuminations;
  for (const Object& object : enumerate_objects(study)) add_once(illuminations, object.illumination);
  return illuminations;
}

std::vector<std::int64_t> enumerate_vpl_counts(const Study& study, Illumination illumination) {
  std::vector<std::int64_t> counts;
  for (const Column& column : enumerate_columns(study)) {
    if (column.object.illumination == illumination) add_once(counts, column.vpl_count);
  }
  std::sort(counts.begin(), counts.end());
  return counts;
}

std::vector<const ColumnFinding*> findings_of(const std::vector<ColumnFinding>& findings,
                                              const Object& object) {
  std::vector<const ColumnFinding*> columns;
  for (const ColumnFinding& finding : findings) {
    if (finding.column.object == object) columns.push_back(&finding);
  }
  std::sort(columns.begin(), columns.end(),
            [](const auto* a, const auto* b) { return a->column.vpl_count < b->column.vpl_count; });
  return columns;
}

std::string describe_subjects(SubjectKind kind) {
  switch (kind) {
    case SubjectKind::kPlanted:
      return "PLANTED SUBJECTS, whose answers were put in";
    case SubjectKind::kLooking:
      return "SIMULATED SUBJECTS, computed from the pixels";
    case SubjectKind::kPerson:
      break;
  }
  return "answers of persons";
}

std::string describe_illumination(Illumination illumination) {
  return illumination == Illumination::kIndirect ? "indirect-only" : "direct-and-indirect";
}

}  // namespace equilux
