// A simulated study for each number of subjects and each seed.
#include "analysis/plan.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/figure.h"
#include "analysis/probability.h"
#include "analysis/prune.h"
#include "analysis/report_tables.h"
#include "analysis/tables.h"
#include "base/error.h"
#include "base/files.h"
#include "base/random.h"
#include "base/version.h"

namespace equilux {
namespace {

// A column as it truly is. shape: one proportion for each clamp level.
struct TrueColumn {
  std::vector<double> artifact;
  std::vector<double> material;
  Threshold artifact_cut;
  Threshold material_cut;
  int window_first = 0;
};

constexpr const char* kPlanFile = "plan.csv";

constexpr std::int64_t kExactN = 1'000'000;  ///< a true proportion as k of n

ColumnCounts make_exact(const std::vector<double>& proportions, const std::vector<int>& levels) {
  ColumnCounts counts;
  for (std::size_t i = 0; i < levels.size(); ++i)
    counts.push_back({levels[i], {std::llround(proportions[i] * static_cast<double>(kExactN)), kExactN}});
  return counts;
}

TrueColumn make_true_column(const Study& study, const PlantedColumn& planted, double lapse_rate,
                            double slope) {
  TrueColumn column;
  for (const int level : study.clamp_levels) {
    column.artifact.push_back(eval_proportion(planted, Experiment::kArtifact, level, slope, lapse_rate));
    column.material.push_back(eval_proportion(planted, Experiment::kMaterial, level, slope, lapse_rate));
  }
  column.artifact_cut =
      find_cut(make_exact(column.artifact, study.clamp_levels), Experiment::kArtifact, Rule::kPaper);
  column.material_cut =
      find_cut(make_exact(column.material, study.clamp_levels), Experiment::kMaterial, Rule::kPaper);
  return column;
}

Count draw(double proportion, int subjects, RandomStream& random) {
  Count count{0, subjects};
  for (int i = 0; i < subjects; ++i) count.k += random.next_double() < proportion ? 1 : 0;
  return count;
}

template <typename IsTested>
ColumnCounts draw_column(const std::vector<double>& proportions, const std::vector<int>& levels, int subjects,
                         RandomStream& random, const IsTested& is_tested) {
  ColumnCounts counts;
  for (std::size_t i = 0; i < levels.size(); ++i)
    counts.push_back({levels[i], is_tested(levels[i]) ? draw(proportions[i], subjects, random) : Count{}});
  return counts;
}

// Sums that become the shares of a row.
struct Sums {
  double below = 0, false_flags = 0, above = 0, hits = 0, columns = 0, cuts_right = 0, ee_right = 0,
         green = 0, supported = 0;

  void add_flags(const ColumnCounts& counts, const std::vector<double>& proportions) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i].count.n == 0) continue;
      const bool is_above = proportions[i] >= kFlagProportion;
      (is_above ? above : below) += 1;
      if (is_flagged(counts[i].count)) (is_above ? hits : false_flags) += 1;
    }
  }
};

bool is_green(const Threshold& artifact, const Threshold& material, std::size_t i) {
  return artifact.states[i] == LevelState::kSame && material.states[i] == LevelState::kSame;
}

// Numbers of subjects in the two experiments.
struct Numbers {
  int artifact = 0, material = 0;
};

void simulate_column(Sums& sums, const TrueColumn& truth, const std::vector<int>& levels,
                     const Numbers& subjects, Rule rule, RandomStream& random) {
  const ColumnCounts artifact = draw_column(
      truth.artifact, levels, subjects.artifact, random,
      [&](int level) { return level >= truth.window_first && level < truth.window_first + kWindowLevels; });
  const Threshold artifact_cut = find_cut(artifact, Experiment::kArtifact, rule);
  const std::vector<int> kept = keep_levels(artifact_cut, levels);
  const ColumnCounts material =
      draw_column(truth.material, levels, subjects.material, random,
                  [&](int level) { return std::find(kept.begin(), kept.end(), level) != kept.end(); });
  const Threshold material_cut = find_cut(material, Experiment::kMaterial, rule);
  sums.add_flags(artifact, truth.artifact);
  sums.add_flags(material, truth.material);
  bool exists = false, truly = false;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    truly |= is_green(truth.artifact_cut, truth.material_cut, i);
    if (!is_green(artifact_cut, material_cut, i)) continue;
    exists = true;
    sums.green += 1;
    sums.supported += is_supported(artifact[i].count) && is_supported(material[i].count) ? 1 : 0;
  }
  sums.columns += 1;
  sums.cuts_right += artifact_cut.cut == truth.artifact_cut.cut ? 1 : 0;
  sums.ee_right += exists == truly ? 1 : 0;
}

double divide(double a, double b) { return b > 0 ? a / b : 0; }

// A sum over studies by another, and the error of that: of a ratio, to first order. source: Cochran 1977,
// Sampling Techniques, section 2.11.
SimulatedShare find_share(const std::vector<Sums>& studies, double Sums::*part, double Sums::*whole) {
  double parts = 0, wholes = 0, squares = 0;
  for (const Sums& study : studies) {
    parts += study.*part;
    wholes += study.*whole;
  }
  SimulatedShare share{divide(parts, wholes), {}};
  if (studies.size() < 2 || wholes == 0) return share;
  for (const Sums& study : studies) {
    const double residual = study.*part - share.value * (study.*whole);
    squares += residual * residual;
  }
  const auto n = static_cast<double>(studies.size());
  share.standard_error = std::sqrt(squares * n / (n - 1)) / wholes;
  return share;
}

SubjectPlanRow make_row(const Numbers& subjects, const std::vector<Sums>& studies) {
  return {subjects.artifact,
          subjects.material,
          find_share(studies, &Sums::false_flags, &Sums::below),
          find_share(studies, &Sums::hits, &Sums::above),
          find_share(studies, &Sums::cuts_right, &Sums::columns),
          find_share(studies, &Sums::ee_right, &Sums::columns),
          find_share(studies, &Sums::green, &Sums::columns),
          find_share(studies, &Sums::supported, &Sums::columns)};
}

std::vector<Numbers> pair_numbers(const SubjectPlanParams& params) {
  const std::vector<int>& material = params.material_subjects;
  if (material.size() > 1 && material.size() != params.subjects.size())
    throw InputError("--material-subjects", "",
                     fmt::format("one number, or {} as in --subjects", params.subjects.size()),
                     fmt::format("{}", material.size()));
  std::vector<Numbers> numbers;
  for (std::size_t i = 0; i < params.subjects.size(); ++i) {
    const int artifact = params.subjects[i];
    numbers.push_back({artifact, material.empty()       ? artifact
                                 : material.size() == 1 ? material[0]
                                                        : material[i]});
  }
  return numbers;
}

// Equal numbers have the stream of one.
std::string name_stream(const Numbers& subjects) {
  if (subjects.artifact == subjects.material) return fmt::format("analysis/plan/{}", subjects.artifact);
  return fmt::format("analysis/plan/{}/{}", subjects.artifact, subjects.material);
}

bool have_equal_numbers(const std::vector<SubjectPlanRow>& rows) {
  return std::all_of(rows.begin(), rows.end(),
                     [](const SubjectPlanRow& row) { return row.subjects == row.material_subjects; });
}

// In the order of the table's columns.
std::array<const SimulatedShare*, 6> shares_of(const SubjectPlanRow& row) {
  return {&row.false_flags, &row.power, &row.cuts_right, &row.ee_right, &row.green_width, &row.supported};
}

std::vector<TrueColumn> make_true_columns(const Study& study, const Truth& truth, double slope) {
  std::vector<TrueColumn> columns;
  for (const Column& column : enumerate_columns(study))
    columns.push_back(make_true_column(study, truth.by_column.at(column), truth.lapse_rate, slope));
  return columns;
}

std::string format_plan_plot(const std::vector<SubjectPlanRow>& rows, FigureFormat format,
                             const std::filesystem::path& file) {
  std::string text = format_terminal(format, 900, 420, file);
  text += "$rows << EOD\n";
  for (const SubjectPlanRow& row : rows) {
    text += fmt::format("{}", row.subjects);
    for (const SimulatedShare* share : shares_of(row)) text += fmt::format(" {}", share->value);
    text += "\n";
  }
  text += fmt::format("EOD\nset xlabel 'subjects {}'\n",
                      have_equal_numbers(rows) ? "in each experiment" : "in the artifact experiment");
  const auto [least, most] = std::minmax_element(
      rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.subjects < b.subjects; });
  // One number of subjects, or levels that are nowhere green, are an empty range to gnuplot.
  if (least != rows.end() && least->subjects == most->subjects)
    text += fmt::format("set xrange [{}:{}]\n", least->subjects - 1, least->subjects + 1);
  const bool is_flat = std::none_of(rows.begin(), rows.end(), [](const SubjectPlanRow& row) {
    return row.green_width.value > 0 || row.supported.value > 0;
  });
  return text + R"(set multiplot layout 1,2
set border lc rgb '#666666'
set grid lc rgb '#dddddd'
set key bottom right
set yrange [0:1]
set ylabel 'share'
plot $rows using 1:2 with linespoints pt 4 dt 2 lc rgb '#d55e00' title 'false flags', \
  $rows using 1:3 with linespoints pt 7 lc rgb '#0072b2' title 'power', \
  $rows using 1:4 with linespoints pt 9 dt 4 lc rgb '#000000' title 'artifact cuts right', \
  $rows using 1:5 with linespoints pt 13 lc rgb '#009e73' title 'EE right'
)" + (is_flat ? "" : "set yrange [0:*]\n") +
         R"(set ylabel 'clamp levels of a column'
plot $rows using 1:6 with linespoints pt 7 lc rgb '#009e73' title 'green', \
  $rows using 1:7 with linespoints pt 4 dt 2 lc rgb '#000000' title 'green and supported'
unset multiplot
)";
}

}  // namespace

double eval_proportion(const PlantedColumn& planted, Experiment experiment, int level, double slope,
                       double lapse_rate) {
  const double beyond = experiment == Experiment::kArtifact ? planted.artifact_free_from - 0.5 - level
                                                            : level - (planted.material_same_to + 0.5);
  const double seen = slope > 0 ? 1 / (1 + std::exp(-beyond / slope)) : beyond > 0 ? 1 : 0;
  return 0.5 + 0.5 * (1 - lapse_rate) * seen;
}

std::vector<SubjectPlanRow> simulate_plan(const Study& study, const Truth& truth, const Windows& windows,
                                          const SubjectPlanParams& params) {
  std::vector<TrueColumn> columns = make_true_columns(study, truth, params.slope);
  const auto names = enumerate_columns(study);
  for (std::size_t c = 0; c < names.size(); ++c)
    columns[c].window_first = windows.by_column.at(names[c]).first_level;
  std::vector<SubjectPlanRow> rows;
  for (const Numbers& subjects : pair_numbers(params)) {
    std::vector<Sums> studies(static_cast<std::size_t>(params.studies));
    for (std::size_t number = 0; number < studies.size(); ++number) {
      RandomStream random(params.seed, name_stream(subjects), number);
      for (const TrueColumn& column : columns)
        simulate_column(studies[number], column, study.clamp_levels, subjects, params.rule, random);
    }
    rows.push_back(make_row(subjects, studies));
  }
  return rows;
}

double find_true_width(const Study& study, const Truth& truth) {
  double green = 0, columns = 0;
  for (const auto& [column, planted] : truth.by_column) {
    columns += 1;
    for (const int level : study.clamp_levels) green += is_equivalent(planted, level) ? 1 : 0;
  }
  return divide(green, columns);
}

Table make_plan_table(const std::vector<SubjectPlanRow>& rows) {
  Table table{{"subjects", "material_subjects"}, {}};
  for (const char* share : {"false_flags", "power", "cuts_right", "ee_right", "green_width", "supported"}) {
    table.columns.push_back(share);
    table.columns.push_back(fmt::format("{}_se", share));
  }
  for (const SubjectPlanRow& row : rows) {
    table.rows.push_back({fmt::format("{}", row.subjects), fmt::format("{}", row.material_subjects)});
    for (const SimulatedShare* share : shares_of(row)) {
      table.rows.back().push_back(format_number(share->value));
      table.rows.back().push_back(format_number(share->standard_error));
    }
  }
  return table;
}

std::string format_plan(const std::vector<SubjectPlanRow>& rows, double true_width) {
  std::string text = "subjects  false flags  power  cuts right  EE right  green levels  supported\n";
  double shares_error = 0, levels_error = 0;
  for (const SubjectPlanRow& row : rows) {
    const std::string subjects = row.subjects == row.material_subjects
                                     ? fmt::format("{}", row.subjects)
                                     : fmt::format("{}, {}", row.subjects, row.material_subjects);
    text += fmt::format("{:>8}  {:>11.3f}  {:>5.3f}  {:>10.3f}  {:>8.3f}  {:>12.2f}  {:>9.2f}\n", subjects,
                        row.false_flags.value, row.power.value, row.cuts_right.value, row.ee_right.value,
                        row.green_width.value, row.supported.value);
    for (const auto* share : {&row.false_flags, &row.power, &row.cuts_right, &row.ee_right})
      shares_error = std::max(shares_error, share->standard_error.value_or(0));
    for (const auto* levels : {&row.green_width, &row.supported})
      levels_error = std::max(levels_error, levels->standard_error.value_or(0));
  }
  if (shares_error > 0)
    text += fmt::format("standard errors of the simulation: shares at most {:.3f}, levels at most {:.3f}\n",
                        shares_error, levels_error);
  return text + fmt::format("in truth {:.2f} levels of a column are equivalent\n", true_width);
}

Json make_plan_json(const Study& study, const Truth& truth, const Windows& windows,
                    const SubjectPlanParams& params, const std::vector<SubjectPlanRow>& rows) {
  Json json;
  json.set("schema", "equilux-plan").set("schema_version", 1);
  json.set("producer", std::string("equilux-analyze ") + kVersion);
  json.set("study", study.name).set("study_digest", study.digest);
  json.set("truth_digest", truth.digest).set("windows_digest", windows.digest);
  json.set("rule", format_rule(params.rule)).set("slope", params.slope).set("lapse_rate", truth.lapse_rate);
  json.set("studies", params.studies).set("seed", params.seed).set("flag_percent", kFlagPercent);
  json.set("support_level", kSupportLevel).set("true_green_width", find_true_width(study, truth));
  return json.set("rows", make_rows_json({kPlanFile, make_plan_table(rows)}));
}

void write_plan(const std::vector<SubjectPlanRow>& rows, const Json& json,
                const std::filesystem::path& folder) {
  const ReportTable table{kPlanFile, make_plan_table(rows)};
  make_folder(folder);
  save_text(folder / table.file, format_csv(table.table));
  save_text(folder / (table.file + "-metadata.json"), format_json(make_csv_metadata({table})));
  save_text(folder / "plan.json", format_json(json));
  draw_plot(folder / "plan.svg",
            [&](const auto& part) { return format_plan_plot(rows, FigureFormat::kSvg, part); });
  draw_plot(folder / "plan.pdf",
            [&](const auto& part) { return format_plan_plot(rows, FigureFormat::kPdf, part); });
}

}  // namespace equilux
