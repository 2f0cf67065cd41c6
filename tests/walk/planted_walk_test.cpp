// From a planted truth through the real programs and back: equilux-session, the log, equilux-analyze, the CSV
// files. With 120 subjects nothing may be lost on the way; mutants of the tables must be noticed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiment/fake_study.h"
#include "tests/support/json_edit.h"
#include "tests/walk/planted_findings.h"
#include "tests/walk/programs.h"

namespace equilux {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr int kSubjects = 120;
const std::string kSeed = "1";

ReportTables walk(const StudyFolder& folder) {
  const std::string root = folder.root.string(), subjects = std::to_string(kSubjects);
  run_well("session",
           {"simulate", root, "--experiment", "artifact", "--subjects", subjects, "--seed", kSeed});
  run_well("analyze", {"prune", root, "--kind", "planted"});
  run_well("session",
           {"simulate", root, "--experiment", "material", "--subjects", subjects, "--seed", kSeed});
  run_well("analyze", {"report", root, "--kind", "planted"});
  return load_report_tables(folder.report_folder());
}

class Comparison {
 public:
  void expect(const std::string& place, const std::string& wanted, const std::string& got) {
    if (wanted != got) breaches.push_back(fmt::format("{}: expected \"{}\", got \"{}\"", place, wanted, got));
  }
  std::vector<std::string> breaches;
};

std::string format_cut(const std::optional<int>& cut) { return cut ? fmt::format("C{}", *cut) : ""; }

using Findings = std::map<std::string, PlantedFinding>;

void compare_cells(const std::vector<Record>& cells, const Findings& findings, Comparison& comparison) {
  comparison.expect("rows of cells.csv", fmt::format("{}", 2 * 11 * findings.size()),
                    fmt::format("{}", cells.size()));
  for (const Record& row : cells) {
    const PlantedFinding& finding = findings.at(column_name(row));
    const auto tested = row.at("experiment") == "artifact" ? finding.window() : finding.kept;
    const bool is_tested = std::count(tested.begin(), tested.end(), *parse_cut(row.at("clamp"))) > 0;
    comparison.expect(fmt::format("n of {} {} {}", row.at("experiment"), column_name(row), row.at("clamp")),
                      is_tested ? std::to_string(kSubjects) : "0", row.at("n"));
  }
}

void compare_thresholds(const std::vector<Record>& rows, const Findings& findings, Comparison& comparison) {
  comparison.expect("rows of thresholds.csv", fmt::format("{}", 2 * 2 * findings.size()),
                    fmt::format("{}", rows.size()));
  for (const Record& row : rows) {
    const PlantedFinding& finding = findings.at(column_name(row));
    const bool is_artifact = row.at("experiment") == "artifact";
    const std::string place =
        fmt::format("{} {} {} ", row.at("rule"), row.at("experiment"), column_name(row));
    comparison.expect(place + "cut", format_cut(is_artifact ? finding.artifact_cut : finding.material_cut),
                      row.at("cut"));
    comparison.expect(place + "status", is_artifact ? finding.artifact_status : finding.material_status,
                      row.at("status"));
    comparison.expect(place + "tested", list_levels(is_artifact ? finding.window() : finding.kept),
                      row.at("tested"));
  }
}

void compare_ee(const std::vector<Record>& rows, const Findings& findings, Comparison& comparison) {
  comparison.expect("rows of ee.csv", fmt::format("{}", findings.size()), fmt::format("{}", rows.size()));
  for (const Record& row : rows) {
    const PlantedFinding& finding = findings.at(column_name(row));
    for (const std::string rule : {"paper", "isotonic"}) {
      comparison.expect(fmt::format("ee_{} {}", rule, column_name(row)),
                        finding.green.empty() ? "false" : "true", row.at("ee_" + rule));
      comparison.expect(fmt::format("green_{} {}", rule, column_name(row)), list_levels(finding.green),
                        row.at("green_" + rule));
    }
  }
}

/// Everything in which the tables differ from what was planted.
std::vector<std::string> find_breaches(const ReportTables& tables, const Findings& findings) {
  Comparison comparison;
  compare_cells(tables.cells, findings, comparison);
  compare_thresholds(tables.thresholds, findings, comparison);
  compare_ee(tables.ee, findings, comparison);
  return comparison.breaches;
}

Findings load_planted_findings(const StudyFolder& folder) {
  const Study study = load_folder_study(folder);
  const Truth truth = load_truth(folder.truth(), study);
  EXPECT_EQ(truth.lapse_rate, 0.02);
  return make_planted_findings(truth, load_windows(folder.windows(), study));
}

// Seed 1, 120 subjects in each experiment, lapse rate .02: a guessed cell is flagged with probability 2e-8.
TEST(PlantedWalk, BringsTheTruthOfPocketBackExactly) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path(), "pocket");
  EXPECT_THAT(find_breaches(walk(folder), load_planted_findings(folder)), IsEmpty());
}

TEST(PlantedWalk, BringsTheTruthOfPaperBackExactly) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path(), "paper");
  EXPECT_THAT(find_breaches(walk(folder), load_planted_findings(folder)), IsEmpty());
}

// Columns that the default truths do not have: never free of artifacts behind the window, free before it,
// material changed from the start, never changed.
TEST(PlantedWalk, BringsThresholdsOutsideTheWindowsBackCensored) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path(), "pocket");
  Json truth = parse_json(load_text(folder.truth()), "truth");
  const std::vector<std::pair<std::string, std::string>> thresholds = {
      {"C0", "C10"},   {"C1", "C1"}, {"C9", "C9"}, {"never", "never"},
      {"C8", "never"}, {"C2", "C2"}, {"C5", "C6"}, {"C3", "C3"}};
  for (std::size_t i = 0; i < thresholds.size(); ++i) {
    truth = with(truth, fmt::format("/columns/{}/artifact_free_from", i), thresholds[i].first);
    truth = with(truth, fmt::format("/columns/{}/material_same_to", i), thresholds[i].second);
  }
  save_text(folder.truth(), format_json(truth));
  const Findings findings = load_planted_findings(folder);
  EXPECT_EQ(findings.at("G0 MS ind 1000").artifact_status, "censored_low");
  EXPECT_EQ(findings.at("G0 GS ind 100000").artifact_status, "censored_high");
  EXPECT_THAT(find_breaches(walk(folder), findings), IsEmpty());
}

// A window that ends at C10, with artifacts to the end: the column is dropped.
TEST(PlantedWalk, DropsAColumnThatIsNeverFreeOfArtifacts) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path(), "pocket");
  save_fake_truth(folder, 0.02, 0.5, "never", "C10", folder.truth());
  Json windows = parse_json(load_text(folder.windows()), "windows");
  for (int i = 0; i < 8; ++i)
    windows = with(windows, fmt::format("/windows/{}/first", i), i == 0 ? "C7" : "C6");
  save_text(folder.windows(), format_json(windows));
  const Findings findings = load_planted_findings(folder);
  EXPECT_EQ(findings.at("G0 MS ind 1000").artifact_status, "none");
  EXPECT_THAT(findings.at("G0 MS ind 100000").kept, ElementsAre(10));
  EXPECT_THAT(find_breaches(walk(folder), findings), IsEmpty());
}

// The rules worked by hand for three columns of pocket.
TEST(PlantedWalk, ExpectsWhatTheRulesSay) {
  const TemporaryFolder temporary;
  const auto findings = load_planted_findings(make_fake_study(temporary.path(), "pocket"));
  const PlantedFinding& none = findings.at("G0 MS ind 1000");  // free from C10, same to C3
  EXPECT_EQ(none.artifact_cut, 10);
  EXPECT_THAT(none.kept, ElementsAre(10));
  EXPECT_EQ(none.material_cut, std::nullopt);
  EXPECT_THAT(none.green, IsEmpty());
  const PlantedFinding& some = findings.at("G2 GS ind 100000");  // free from C2, same to C8
  EXPECT_THAT(some.kept, ElementsAre(2, 4, 6, 8, 10));
  EXPECT_EQ(some.material_cut, 8);
  EXPECT_THAT(some.green, ElementsAre(2, 3, 4, 5, 6, 7, 8));
  const PlantedFinding& thinned = findings.at("G2 GS ind 1000");  // free from C6, same to C8
  EXPECT_EQ(thinned.visible, 2);
  EXPECT_THAT(thinned.green, ElementsAre(6, 7, 8));
}

class PlantedMutant : public ::testing::Test {
 protected:
  static Record& find_row(std::vector<Record>& rows, const Record& wanted) {
    return *std::find_if(rows.begin(), rows.end(), [&](const Record& row) {
      return std::all_of(wanted.begin(), wanted.end(),
                         [&](const auto& field) { return row.at(field.first) == field.second; });
    });
  }

  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path(), "pocket");
  Findings findings_ = load_planted_findings(folder_);
  ReportTables tables_ = walk(folder_);
};

TEST_F(PlantedMutant, OfEveryTableIsNoticed) {
  ASSERT_THAT(find_breaches(tables_, findings_), IsEmpty());
  const Record column = {{"geometry", "G2"}, {"material", "GS"}, {"illumination", "ind"}, {"vpls", "1000"}};
  const auto breaches_with = [&](auto table, Record row, const std::string& field, const std::string& value) {
    ReportTables mutant = tables_;
    row.insert(column.begin(), column.end());
    find_row(mutant.*table, row).at(field) = value;
    return find_breaches(mutant, findings_);
  };
  for (const std::string rule : {"paper", "isotonic"}) {
    for (const std::string cut : {"C5", "C7", ""}) {
      EXPECT_THAT(
          breaches_with(&ReportTables::thresholds, {{"experiment", "artifact"}, {"rule", rule}}, "cut", cut),
          SizeIs(1))
          << "a cut moved by one level, or lost";
    }
    EXPECT_THAT(
        breaches_with(&ReportTables::thresholds, {{"experiment", "material"}, {"rule", rule}}, "cut", "C9"),
        SizeIs(1));
    EXPECT_THAT(breaches_with(&ReportTables::ee, {}, "ee_" + rule, "false"), SizeIs(1));
    EXPECT_THAT(breaches_with(&ReportTables::ee, {}, "green_" + rule, "C6 C7"), SizeIs(1));
  }
  for (const std::string experiment : {"artifact", "material"}) {
    EXPECT_THAT(breaches_with(&ReportTables::cells, {{"experiment", experiment}, {"clamp", "C6"}}, "n",
                              std::to_string(kSubjects - 1)),
                SizeIs(1))
        << "an answer dropped";
  }
  ReportTables shorter = tables_;
  shorter.cells.pop_back();
  EXPECT_THAT(find_breaches(shorter, findings_), SizeIs(1)) << "a cell dropped";
}

}  // namespace
}  // namespace equilux
