// Trends against enumeration, the sign test and planted truths.
#include "analysis/trends.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

// R: p.adjust(c(.01, .04, .03, .005), "holm")
TEST(Holm, adjusts_as_R_does) {
  const auto adjusted = adjust_holm({0.01, 0.04, 0.03, 0.005});
  const double expected[] = {0.03, 0.06, 0.06, 0.02};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(adjusted[i], expected[i], 1e-15);
  EXPECT_TRUE(adjust_holm({}).empty());
  EXPECT_EQ(adjust_holm({0.7, 0.7}), (std::vector<double>{1, 1}));
}

struct Case {
  Study study;
  std::vector<ColumnFinding> findings;
  Uncertainty uncertainty;
};

// Verdicts by hand; the resamples all agree with them.
Case make_case(const std::string& name, const std::function<bool(const Column&)>& exists) {
  Case made{load_protocol(name), {}, {}};
  made.uncertainty.subjects = 12;
  for (const Column& column : enumerate_columns(made.study)) {
    ColumnFinding finding;
    finding.column = column;
    finding.by_rule[0].verdict = exists(column) ? Verdict::kExists : Verdict::kNone;
    finding.by_rule[1].verdict = Verdict::kUntested;
    made.findings.push_back(finding);
    made.uncertainty.resamples[0].push_back(exists(column) ? Resampled::kExists : Resampled::kNone);
    made.uncertainty.resamples[1].push_back(Resampled::kUntested);
  }
  return made;
}

const Trend& find_trend(const std::vector<Trend>& trends, const std::string& from, const std::string& to) {
  return *std::find_if(trends.begin(), trends.end(),
                       [&](const Trend& trend) { return trend.from == from && trend.to == to; });
}

TEST(Trends, of_the_paper_are_asked_along_counts_geometries_materials_and_illumination) {
  const Case made = make_case("paper", [](const Column& column) { return column.vpl_count > 1000; });
  const auto trends = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
  std::vector<std::string> names;
  for (const Trend& trend : trends) names.push_back(trend.from + "-" + trend.to);
  EXPECT_EQ(names, (std::vector<std::string>{"1k-5M", "1k-100k", "100k-5M", "G0-G3", "MS-MR", "MS-BS",
                                             "BS-BR", "BS-GS", "ind-dir"}));
  const Trend& counts = find_trend(trends, "1k", "5M");
  EXPECT_EQ(counts.strata, 40);
  EXPECT_EQ(counts.pairs, 120);
  EXPECT_EQ(counts.clusters, 40);
  EXPECT_EQ(counts.gained, 80);
  EXPECT_EQ(counts.lost, 0);
  EXPECT_TRUE(counts.holds);
  EXPECT_NEAR(*counts.effect, 80.0 / 120, 1e-15);
  EXPECT_EQ(*counts.interval, (Interval{80.0 / 120, 80.0 / 120}));
  for (const char* to : {"MR", "BS", "dir", "G3"}) {
    const Trend& flat =
        *std::find_if(trends.begin(), trends.end(), [&](const Trend& t) { return t.to == to; });
    EXPECT_EQ(flat.status, TrendStatus::kFlat) << to;
    EXPECT_EQ(flat.p, 1);
    EXPECT_FALSE(flat.holds);
  }
  EXPECT_EQ(find_trend(trends, "100k", "5M").status, TrendStatus::kFlat);
}

TEST(Trends, of_a_material_step_are_lost_where_the_later_material_loses) {
  const Case made = make_case("paper", [](const Column& column) { return column.object.material == "MS"; });
  const auto trends = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
  const Trend& step = find_trend(trends, "MS", "MR");
  EXPECT_EQ(step.lost, 24);
  EXPECT_EQ(*step.effect, -1);
  EXPECT_EQ(step.clusters, 8) << "four geometries in two illuminations, each at three VPL counts";
  EXPECT_NEAR(step.p, std::ldexp(1.0, -7), 1e-15);
  EXPECT_NEAR(step.p_least, std::ldexp(1.0, -7), 1e-15);
  EXPECT_NEAR(step.p_holm, 9 * std::ldexp(1.0, -7), 1e-15) << "of nine trends";
  EXPECT_FALSE(step.holds);
}

TEST(Trends, that_hold_are_said_to_be_more_often_or_less_often) {
  for (const bool more : {true, false}) {
    const Case made =
        make_case("paper", [&](const Column& column) { return (column.vpl_count > 1000) == more; });
    const auto trends = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
    const Trend& step = find_trend(trends, "1k", "100k");
    EXPECT_TRUE(step.holds);
    EXPECT_NE(describe_trend(step).find(more ? "more often" : "less often"), std::string::npos);
  }
}

// Five subjects: the same verdicts and p, and nothing that holds.
TEST(Trends, of_too_few_subjects_have_no_interval) {
  Case made = make_case("paper", [](const Column& column) { return column.vpl_count > 1000; });
  made.uncertainty.subjects = 5;
  const auto trends = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
  const Trend& step = find_trend(trends, "1k", "100k");
  EXPECT_EQ(step.status, TrendStatus::kTooFewSubjects);
  EXPECT_FALSE(step.interval);
  EXPECT_FALSE(step.holds);
  EXPECT_LT(step.p_holm, 0.001);
  made.uncertainty.subjects = 6;
  const auto enough = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
  EXPECT_TRUE(find_trend(enough, "1k", "100k").holds);
}

// Of every object of the later material one VPL count has no verdict, of those of G0 none: a pair is left
// out, and an object without pairs.
TEST(Trends, count_the_objects_that_have_a_pair) {
  Case made = make_case("paper", [](const Column& column) { return column.object.material == "MS"; });
  for (ColumnFinding& finding : made.findings) {
    const bool is_gone = finding.column.object.geometry == "G0" || finding.column.vpl_count == 1000;
    if (finding.column.object.material == "MR" && is_gone) finding.by_rule[0].verdict = Verdict::kUntested;
  }
  const auto trends = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
  const Trend& step = find_trend(trends, "MS", "MR");
  EXPECT_EQ(step.pairs, 12);
  EXPECT_EQ(step.clusters, 6);
  EXPECT_NEAR(step.p, std::ldexp(1.0, -5), 1e-15);
}

TEST(Trends, without_verdicts_have_no_pairs_and_no_number_that_is_not_finite) {
  const Case made = make_case("paper", [](const Column&) { return true; });
  for (const Trend& trend : find_trends(made.study, made.findings, Rule::kIsotonic, made.uncertainty)) {
    EXPECT_EQ(trend.status, TrendStatus::kNoPairs);
    EXPECT_FALSE(trend.effect || trend.interval);
    EXPECT_EQ(trend.p, 1);
    EXPECT_EQ(trend.p_holm, 1);
  }
}

// Bunny and Dragon stand in no order with the blobs, nor with each other.
TEST(Trends, along_geometries_are_asked_of_the_blobs_alone) {
  const Case made = make_case("validation", [](const Column& column) {
    return column.object.geometry == "Bunny" || column.object.geometry == "Dragon";
  });
  const auto trends = find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty);
  const Trend& blobs = *std::find_if(trends.begin(), trends.end(),
                                     [](const Trend& trend) { return trend.factor == "geometry"; });
  EXPECT_EQ(blobs.from, "G0");
  EXPECT_EQ(blobs.to, "G3");
  EXPECT_EQ(blobs.strata, 3) << "LG at three counts";
  EXPECT_EQ(blobs.pairs, 18);
  EXPECT_EQ(blobs.status, TrendStatus::kFlat);
}

// Holm of .01 and .02 is .02 and .02: what has nothing to compare is no third hypothesis.
TEST(Trends, that_compare_nothing_are_not_allowed_for) {
  Trend first, second, nothing;
  first.status = second.status = TrendStatus::kTested;
  first.p = 0.01;
  second.p = 0.02;
  std::vector<Trend> trends{nothing, first, second};
  adjust_trends(trends);
  EXPECT_EQ(trends[0].p_holm, 1);
  EXPECT_DOUBLE_EQ(trends[1].p_holm, 0.02);
  EXPECT_DOUBLE_EQ(trends[2].p_holm, 0.02);
}

TEST(Trends, of_a_study_of_one_level_are_not_asked) {
  const Case made = make_case("normalisation", [](const Column&) { return true; });
  for (const Trend& trend : find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty))
    EXPECT_TRUE(trend.factor == "vpls" || trend.factor == "geometry") << trend.factor;
}

// The normalised study has MR on G0..G3 at three counts, indirect-only: twelve columns of the paper's 120.
TEST(Trends, from_plain_to_normalised_pair_the_columns_that_both_have) {
  const Case plain = make_case("paper", [](const Column&) { return false; });
  const Case normalised = make_case("normalisation", [](const Column&) { return true; });
  const Trend trend =
      compare_studies({"paper", plain.findings, plain.uncertainty},
                      {"normalisation", normalised.findings, normalised.uncertainty}, Rule::kPaper);
  EXPECT_EQ(trend.factor, "study");
  EXPECT_EQ(trend.pairs, 12);
  EXPECT_EQ(trend.gained, 12);
  EXPECT_EQ(trend.effect, 1);
  EXPECT_EQ(trend.interval, (Interval{1, 1}));
  EXPECT_EQ(trend.clusters, 4);
  EXPECT_NEAR(trend.p, std::ldexp(1.0, -3), 1e-15) << "four objects: no verdicts could give less";
  EXPECT_EQ(trend.p_least, trend.p);
  EXPECT_FALSE(trend.holds);
  const Case other = make_case("pocket", [](const Column&) { return true; });
  EXPECT_EQ(compare_studies({"pocket", other.findings, other.uncertainty},
                            {"normalisation", normalised.findings, normalised.uncertainty}, Rule::kPaper)
                .status,
            TrendStatus::kNoPairs);
}

// Answers of twelve subjects to one level of each column, right with probability .65: near the cut. Seed 5.
std::vector<AnswerRow> answer_by_chance(const Study& study, Experiment experiment) {
  std::vector<AnswerRow> answers;
  for (int subject = 0; subject < 12; ++subject) {
    RandomStream random(5, format_experiment(experiment), static_cast<std::uint64_t>(subject));
    for (const Cell& cell : enumerate_cells(study)) {
      if (cell.clamp_level == 4) answers.push_back({subject + 1, subject, cell, random.next_double() < 0.65});
    }
  }
  return answers;
}

Case answer_case(const std::string& name) {
  Case made{load_protocol("pocket"), {}, {}};
  made.study.name = name;
  const auto artifact = answer_by_chance(made.study, Experiment::kArtifact);
  const auto material = answer_by_chance(made.study, Experiment::kMaterial);
  made.findings = find_equivalence(made.study, tally_answers(artifact, made.study),
                                   tally_answers(material, made.study), nullptr);
  made.uncertainty = find_uncertainty(made.study, made.findings, make_response_matrix(artifact),
                                      make_response_matrix(material), {1, 1, 400, 1});
  return made;
}

// Subjects of two studies stand in no pairs, whatever their rows: drawn alike, equal answers would leave no
// doubt of a difference of none. 400 resamples, seed 1.
TEST(Trends, between_studies_draw_the_subjects_of_each_by_themselves) {
  const Case plain = answer_case("plain"), other = answer_case("other"), again = answer_case("plain");
  EXPECT_EQ(plain.uncertainty.resamples, again.uncertainty.resamples);
  const Trend trend = compare_studies({"plain", plain.findings, plain.uncertainty},
                                      {"other", other.findings, other.uncertainty}, Rule::kPaper);
  EXPECT_EQ(trend.effect, 0);
  ASSERT_TRUE(trend.interval);
  EXPECT_LE(trend.interval->lower, -0.25);
  EXPECT_GE(trend.interval->upper, 0.25);
}

TEST(Trends, do_not_hold_where_other_subjects_could_have_given_the_opposite) {
  Case made = make_case("paper", [](const Column& column) { return column.vpl_count > 1000; });
  const auto row = made.uncertainty.resamples[0];
  auto& resamples = made.uncertainty.resamples[0];
  for (int i = 0; i < 20; ++i) resamples.insert(resamples.end(), row.size(), Resampled::kNone);
  resamples.insert(resamples.end(), row.begin(), row.end());
  EXPECT_FALSE(
      find_trend(find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty), "1k", "5M").holds);
}

// Columns of 1k have no EE since they were dropped; a resample that would keep them cannot say what they
// have.
TEST(Trends, take_what_a_dropped_column_might_have_for_what_moves_them_farther) {
  Case made = make_case("paper", [](const Column& column) { return column.vpl_count > 1000; });
  const auto step = [&] {
    return find_trend(find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty), "1k", "100k");
  };
  EXPECT_TRUE(step().holds);
  auto& resamples = made.uncertainty.resamples[0];
  for (Resampled& resampled : resamples) {
    if (resampled == Resampled::kNone) resampled = Resampled::kUntested;
  }
  EXPECT_EQ(step().effect, 1);
  EXPECT_EQ(step().interval, (Interval{0, 1})) << "with EE at 1k nothing is gained";
  EXPECT_FALSE(step().holds);
  for (ColumnFinding& finding : made.findings) finding.material = make_column({{4, {14, 14}}});
  EXPECT_FALSE(step().interval) << "asked, and in no resample: such a pair is left out";
  for (ColumnFinding& finding : made.findings) {
    if (finding.column.vpl_count == 1000) finding.by_rule[0].verdict = Verdict::kUntested;
  }
  for (Resampled& resampled : resamples) {
    if (resampled == Resampled::kUntested) resampled = Resampled::kNone;
  }
  EXPECT_EQ(step().pairs, 0);
  const Trend along =
      find_trend(find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty), "1k", "5M");
  EXPECT_EQ(along.interval, (Interval{0, 0})) << "a column that waits for its material answers stays out";
}

TEST(Trends, do_not_hold_where_there_are_no_other_subjects) {
  Case made = make_case("paper", [](const Column& column) { return column.vpl_count > 1000; });
  const Case many = made;
  made.uncertainty.resamples = {};  // of one subject
  for (const Trend& trend : find_trends(made.study, made.findings, Rule::kPaper, made.uncertainty)) {
    EXPECT_FALSE(trend.interval) << trend.to;
    EXPECT_FALSE(trend.holds) << trend.to;
  }
  const ComparedStudy one{"one", made.findings, made.uncertainty},
      other{"other", many.findings, many.uncertainty};
  for (const bool turned : {false, true}) {
    const Trend trend =
        turned ? compare_studies(other, one, Rule::kPaper) : compare_studies(one, other, Rule::kPaper);
    EXPECT_FALSE(trend.interval);
    EXPECT_FALSE(trend.holds);
  }
}

}  // namespace
}  // namespace equilux::tests
