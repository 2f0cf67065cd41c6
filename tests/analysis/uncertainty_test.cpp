// Posterior draws against exact probabilities, resampling against its binomial distribution.
#include "analysis/uncertainty.h"

#include <algorithm>
#include <array>
#include <boost/math/distributions/beta.hpp>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "analysis/probability.h"
#include "tests/analysis/answered.h"

namespace equilux::tests {
namespace {

// Probability that level i is the first free one, and that level j is the last unchanged one, cells being
// flagged independently: rule `paper` in closed form.
double eval_exact_posterior(const ColumnFinding& finding) {
  const auto flags = [](const ColumnCounts& counts) {
    std::vector<double> over;
    for (const LevelCount& level : counts) over.push_back(eval_posterior_over(level.count).value_or(-1));
    return over;
  };
  const std::vector<double> artifact = flags(finding.artifact), material = flags(finding.material);
  const auto tested = [](double over) { return over >= 0; };
  const auto first_tested = std::find_if(artifact.begin(), artifact.end(), tested) - artifact.begin();
  const auto first_material = std::find_if(material.begin(), material.end(), tested) - material.begin();
  double probability = 0, none_behind = 1;
  const auto unchanged_up_to_or_beyond = [&](std::ptrdiff_t level) {
    double same = 1;
    std::ptrdiff_t last = -1;
    double sum = 0;
    for (std::ptrdiff_t i = first_material; i < std::ssize(material); ++i) {
      if (!tested(material[i])) continue;
      if (last >= level) sum += same * material[i];
      same *= 1 - material[i];
      last = i;
    }
    return last >= level ? sum + same : sum;
  };
  for (std::ptrdiff_t i = std::ssize(artifact); i-- > 0;) {
    if (!tested(artifact[i])) continue;
    const double cut_after = none_behind * artifact[i];
    if (i + 1 < std::ssize(artifact)) probability += cut_after * unchanged_up_to_or_beyond(i + 1);
    none_behind *= 1 - artifact[i];
  }
  return probability + none_behind * unchanged_up_to_or_beyond(first_tested);
}

// Seed 3, 20,000 draws, 8 columns: four standard errors of each, 0.05 % in all.
TEST(Posterior, of_equivalence_is_the_exact_one_under_the_rule_paper) {
  const Answered answered = from(make_planted_study("pocket", 12, 14, 5, 0.2));
  const auto findings = answered.find();
  const auto results = answered.disturb({3, 20000, 1});
  int uncertain = 0;
  for (std::size_t c = 0; c < findings.size(); ++c) {
    if (!results[c].under(Rule::kPaper).posterior) continue;
    const double exact = eval_exact_posterior(findings[c]);
    EXPECT_NEAR(*results[c].under(Rule::kPaper).posterior, exact,
                4 * std::sqrt(exact * (1 - exact) / 20000) + 1e-12)
        << format_key(findings[c].column);
    uncertain += exact > 0.05 && exact < 0.95 ? 1 : 0;
  }
  EXPECT_GT(uncertain, 2) << "the test would be empty";
}

double eval_upper_tail(int k, int n, double p) {
  double tail = 0, term = std::pow(1 - p, n);
  for (int i = 0; i <= n; ++i) {
    if (i >= k) tail += term;
    term *= p / (1 - p) * (n - i) / (i + 1);
  }
  return tail;
}

// A column tested at all eleven levels, whose proportions are all alike: pools of draws grow long, and their
// products large. The isotonic posterior then lies between one and none, on the side of the truth; seed 5,
// 2,000 draws.
TEST(Posterior, of_long_pools_stays_on_the_side_of_the_counts) {
  for (const bool low : {true, false}) {
    Answered answered = make_two_cells(0, 0, 0, 0);
    const Column column = enumerate_columns(answered.study).front();
    for (int subject = 0; subject < 40; ++subject) {
      for (int level = 0; level < 11; ++level) {
        answered.artifact.push_back(
            {subject + 1, subject, {column, level, false}, subject < (low ? 20 : 38)});
        answered.material.push_back({subject + 1, subject, {column, level, false}, subject < 20});
      }
    }
    const auto isotonic = answered.disturb({5, 2000, 10}).front().under(Rule::kIsotonic);
    EXPECT_EQ(*isotonic.posterior > 0.95, low) << *isotonic.posterior;
    EXPECT_EQ(*isotonic.posterior < 0.05, !low) << *isotonic.posterior;
  }
}

// Middles of `kPieces` pieces of a cell's posterior, each as probable.
constexpr int kPieces = 500;
std::vector<double> split_posterior(const Count& count, double lowest = 0) {
  const boost::math::beta_distribution<double> posterior(static_cast<double>(count.k) + 0.5,
                                                         static_cast<double>(count.n - count.k) + 0.5);
  std::vector<double> middles(kPieces);
  const double below = cdf(posterior, lowest);
  for (int i = 0; i < kPieces; ++i)
    middles[static_cast<std::size_t>(i)] = quantile(posterior, below + (1 - below) * (i + 0.5) / kPieces);
  return middles;
}

// Probabilities that neither, only the lower, or both of two proportions are below the cut once they are
// pooled where the lower is not below the higher, by their n: the rule `isotonic`, over a grid.
struct TwoPooled {
  double none = 0, lower = 0, both = 0;
};
TwoPooled eval_two_pooled(const Count& lower, const Count& higher, double lowest = 0) {
  TwoPooled sum;
  const auto lows = split_posterior(lower, lowest), highs = split_posterior(higher, lowest);
  const auto a = static_cast<double>(lower.n), b = static_cast<double>(higher.n);
  for (const double low : lows) {
    for (const double high : highs) {
      const double pooled = (a * low + b * high) / (a + b);
      const double first = low > high ? pooled : low, second = low > high ? pooled : high;
      (second < kFlagProportion  ? sum.both
       : first < kFlagProportion ? sum.lower
                                 : sum.none) += 1.0 / (kPieces * kPieces);
    }
  }
  return sum;
}

// Two levels of unequal n in each experiment. Artifacts fall with clamp, so that C5 is the lower one;
// material changes rise, so that C4 is. Equivalent is C5 where it is free and unchanged, or C4 where both
// are. Seed 6, 20,000 draws, four standard errors and the grid's own error.
TEST(Posterior, of_equivalence_is_that_of_pooled_proportions_under_the_rule_isotonic) {
  struct Case {
    Count artifact_4, artifact_5, material_4, material_5;
  };
  const std::vector<Case> cases{{{8, 12}, {5, 6}, {6, 7}, {9, 14}},
                                {{9, 12}, {8, 12}, {3, 7}, {10, 14}},
                                {{5, 6}, {9, 12}, {10, 14}, {5, 7}},
                                {{10, 12}, {4, 6}, {5, 7}, {4, 7}}};
  for (const Case& c : cases) {
    Answered answered = make_two_cells(0, 0, 0, 0);
    const Column column = enumerate_columns(answered.study).front();
    const auto add = [&](std::vector<AnswerRow>& rows, int level, const Count& count) {
      for (int i = 0; i < count.n; ++i) rows.push_back({i + 1, i, {column, level, false}, i < count.k});
    };
    add(answered.artifact, 4, c.artifact_4);
    add(answered.artifact, 5, c.artifact_5);
    add(answered.material, 4, c.material_4);
    add(answered.material, 5, c.material_5);
    const TwoPooled free = eval_two_pooled(c.artifact_5, c.artifact_4),
                    same = eval_two_pooled(c.material_4, c.material_5);
    const double exact = free.both * (same.lower + same.both) + free.lower * same.both;
    EXPECT_TRUE(exact > 0.05 && exact < 0.95) << "the case would say nothing: " << exact;
    const auto isotonic = answered.disturb({6, 20000, 1}).front().under(Rule::kIsotonic);
    EXPECT_NEAR(*isotonic.posterior, exact, 4 * std::sqrt(exact * (1 - exact) / 20000) + 0.003);
    const TwoPooled free_above = eval_two_pooled(c.artifact_5, c.artifact_4, 0.5),
                    same_above = eval_two_pooled(c.material_4, c.material_5, 0.5);
    const double above =
        free_above.both * (same_above.lower + same_above.both) + free_above.lower * same_above.both;
    EXPECT_NEAR(*isotonic.posterior_above_half, above, 4 * std::sqrt(above * (1 - above) / 20000) + 0.003);
  }
}

// That a proportion is below the cut, its posterior cut off below one half.
double eval_below_cut_above_half(const Count& count) {
  const boost::math::beta_distribution<double> posterior(static_cast<double>(count.k) + 0.5,
                                                         static_cast<double>(count.n - count.k) + 0.5);
  return 1 - cdf(complement(posterior, kFlagProportion)) / cdf(complement(posterior, 0.5));
}

// One cell in each experiment: EE is both below the cut. Few subjects and many, right, wrong and guessing:
// every way in which draws below one half are replaced. Seed 3, 20,000 draws, four standard errors. The draws
// from the whole prior stay what they were.
TEST(Posterior, above_one_half_is_the_truncated_one_in_closed_form) {
  const std::vector<std::array<int, 4>> cases{{0, 1, 0, 1},   {1, 1, 1, 1},   {0, 2, 1, 2},  {8, 12, 9, 14},
                                              {1, 4, 2, 4},   {3, 12, 2, 14}, {0, 5, 3, 6},  {5, 14, 1, 12},
                                              {0, 12, 7, 14}, {0, 3, 0, 800}, {9, 12, 0, 14}};
  for (const auto& [k_artifact, n_artifact, k_material, n_material] : cases) {
    const auto result =
        make_two_cells(k_artifact, n_artifact, k_material, n_material).disturb({3, 20000, 1}).front();
    const double above = eval_below_cut_above_half({k_artifact, n_artifact}) *
                         eval_below_cut_above_half({k_material, n_material});
    const double whole = (1 - *eval_posterior_over({k_artifact, n_artifact})) *
                         (1 - *eval_posterior_over({k_material, n_material}));
    const auto error = [](double p) { return 4 * std::sqrt(p * (1 - p) / 20000) + 1e-9; };
    for (const Rule rule : kRules) {
      EXPECT_NEAR(*result.under(rule).posterior_above_half, above, error(above)) << k_artifact << k_material;
      EXPECT_NEAR(*result.under(rule).posterior, whole, error(whole)) << k_artifact << k_material;
    }
  }
  EXPECT_NEAR(eval_below_cut_above_half({0, 1}) * eval_below_cut_above_half({0, 1}), 0.47, 0.005)
      << "which docs/analysis.md quotes";
}

// A resample of n subjects of whom k are right is Bin(n, k / n); EE is: neither cell flagged. Seed 4, 20,000
// resamples, four standard errors.
TEST(Bootstrap, over_subjects_of_one_cell_is_binomial) {
  const Answered answered = make_two_cells(8, 12, 9, 14);
  const double expected = (1 - eval_upper_tail(9, 12, 8.0 / 12)) * (1 - eval_upper_tail(11, 14, 9.0 / 14));
  const auto result = answered.disturb({4, 1, 20000}).front();
  EXPECT_EQ(result.under(Rule::kPaper).status, UncertaintyStatus::kEstimated);
  for (const Rule rule : kRules) {
    EXPECT_NEAR(*result.under(rule).bootstrap, expected, 4 * std::sqrt(expected * (1 - expected) / 20000));
  }
}

TEST(Bootstrap, of_answers_that_all_agree_knows_no_doubt) {
  const Answered answered = make_two_cells(0, 12, 0, 14);
  const auto paper = answered.disturb({1, 100, 100}).front().under(Rule::kPaper);
  EXPECT_EQ(paper.bootstrap, 1.0);
  EXPECT_EQ(paper.artifact_cut, (CutRange{5, 5}));
  EXPECT_EQ(paper.material_cut, (CutRange{5, 5}));
  EXPECT_TRUE(paper.artifact_flips.empty() && paper.material_flips.empty());
}

TEST(Bootstrap, shows_a_cut_that_may_lie_at_no_level_as_one_beyond_the_scale) {
  Answered answered = make_two_cells(9, 12, 11, 14);
  for (AnswerRow& row : answered.artifact) row.cell.clamp_level = 10;
  for (AnswerRow& row : answered.material) row.cell.clamp_level = 10;
  const auto paper = answered.disturb({1, 10, 2000}).front().under(Rule::kPaper);
  EXPECT_EQ(paper.artifact_cut, (CutRange{10, 11}));
  EXPECT_EQ(paper.material_cut, (CutRange{-1, 10}));
}

TEST(Bootstrap, lets_a_material_cut_below_the_tested_levels_lie_anywhere_there) {
  const auto paper = make_two_cells(0, 12, 14, 14).disturb({1, 10, 100}).front().under(Rule::kPaper);
  EXPECT_EQ(paper.material_cut, (CutRange{-1, 4})) << "C5 was tested";
}

TEST(Flips, are_the_subjects_without_whom_the_verdict_is_another) {
  // 8 of 12 is not flagged; without one who was wrong it is 8 of 11, which is not either: 800 < 825.
  EXPECT_TRUE(
      make_two_cells(8, 12, 0, 14).disturb({1, 1, 1}).front().under(Rule::kPaper).artifact_flips.empty());
  // 9 of 12 is flagged; without one who was right it is 8 of 11, which is not.
  const auto flips =
      make_two_cells(9, 12, 0, 14).disturb({1, 1, 1}).front().under(Rule::kPaper).artifact_flips;
  EXPECT_EQ(flips, (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
}

// 9 of 12 is flagged in both experiments; only without one who was right in both is neither.
TEST(Flips, leave_a_person_out_of_both_experiments) {
  const Answered answered = make_two_cells(9, 12, 9, 12);
  const ResponseMatrix artifact = make_response_matrix(answered.artifact),
                       material = make_response_matrix(answered.material);
  const auto flips_of = [&](const ResponseMatrix& seen, const ResponseMatrix& changed) {
    return find_uncertainty(answered.study, answered.find(), seen, changed, {1, 1, 1})
        .columns.front()
        .under(Rule::kPaper);
  };
  EXPECT_TRUE(flips_of(artifact, material).artifact_flips.empty()) << "strangers";
  const auto codes = make_codes(12, 1);
  const auto flips = flips_of(group_by_person(artifact, codes), group_by_person(material, codes));
  EXPECT_EQ(flips.artifact_flips, (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_TRUE(flips.material_flips.empty()) << "each person once";
}

// Six persons of two sessions each, four of whom are right in both: 8 of 12. A resample is twice
// Bin(6, 4 / 6), flagged from 5 on. Seed 4, 20,000 resamples, four standard errors, which tell it from
// Bin(12, 8 / 12).
TEST(Bootstrap, draws_persons_and_not_their_sessions) {
  const Answered answered = make_two_cells(8, 12, 0, 14);
  const auto share_of = [&](const ResponseMatrix& artifact) {
    const Uncertainty found = find_uncertainty(answered.study, answered.find(), artifact,
                                               make_response_matrix(answered.material), {4, 1, 20000});
    return *found.columns.front().under(Rule::kPaper).bootstrap;
  };
  const auto is_near = [](double share, double expected) {
    return std::abs(share - expected) <= 4 * std::sqrt(expected * (1 - expected) / 20000);
  };
  const double by_person = 1 - eval_upper_tail(5, 6, 4.0 / 6),
               by_session = 1 - eval_upper_tail(9, 12, 8.0 / 12);
  const ResponseMatrix sessions = make_response_matrix(answered.artifact);
  EXPECT_TRUE(is_near(share_of(group_by_person(sessions, make_codes(12, 2))), by_person));
  EXPECT_TRUE(is_near(share_of(sessions), by_session));
  EXPECT_FALSE(is_near(by_session, by_person)) << "the test would tell nothing";
}

TEST(Uncertainty, of_stiff_columns_has_a_status_and_no_number_that_is_not_finite) {
  const auto status_of = [](const Answered& answered) {
    const auto column = answered.disturb({1, 50, 50}).front();
    EXPECT_EQ(column.under(Rule::kPaper).status, column.under(Rule::kIsotonic).status);
    return column;
  };
  EXPECT_EQ(status_of(make_two_cells(0, 0, 0, 0)).under(Rule::kPaper).status, UncertaintyStatus::kUntested);
  EXPECT_EQ(status_of(make_two_cells(0, 12, 0, 0)).under(Rule::kPaper).status, UncertaintyStatus::kUntested);
  EXPECT_EQ(status_of(make_two_cells(1, 1, 1, 1)).under(Rule::kPaper).status, UncertaintyStatus::kOneSubject);
  EXPECT_FALSE(status_of(make_two_cells(1, 1, 1, 1)).under(Rule::kPaper).bootstrap);
  EXPECT_TRUE(status_of(make_two_cells(1, 1, 1, 1)).under(Rule::kPaper).posterior);
  for (const auto& [k, n] :
       std::vector<std::pair<int, int>>{{0, 12}, {12, 12}, {6, 12}, {3, 6}, {2, 5}, {0, 2}, {2, 2}}) {
    const auto result = status_of(make_two_cells(k, n, k, n));
    const bool is_enough = n >= 6;
    EXPECT_EQ(result.under(Rule::kPaper).status,
              is_enough ? UncertaintyStatus::kEstimated : UncertaintyStatus::kTooFewSubjects);
    for (const Rule rule : kRules) {
      const RuleUncertainty& under = result.under(rule);
      EXPECT_TRUE(*under.posterior >= 0 && *under.posterior <= 1);
      EXPECT_TRUE(*under.bootstrap >= 0 && *under.bootstrap <= 1);
      EXPECT_EQ(under.artifact_cut.has_value(), is_enough) << n;
      EXPECT_EQ(under.material_cut.has_value(), is_enough) << n;
    }
  }
}

TEST(Uncertainty, of_a_column_that_pruning_dropped_says_that_it_has_no_candidates) {
  Answered answered = make_two_cells(12, 12, 0, 0);
  for (AnswerRow& row : answered.artifact) row.cell.clamp_level = 10;
  const auto result = answered.disturb({1, 10, 10}).front();
  EXPECT_EQ(result.under(Rule::kPaper).status, UncertaintyStatus::kNoCandidates);
  EXPECT_EQ(result.under(Rule::kPaper).artifact_cut, (CutRange{11, 11}));
}

// Some level is free under `paper` iff C10 is not flagged: in closed form by its posterior, and Bin(12, 9 /
// 12) drawn again. Seed 3, 20,000 draws, four standard errors. Without one of the nine it is 8 of 11, not
// flagged.
TEST(Uncertainty, of_a_dropped_column_says_how_sure_it_is_that_no_level_is_free) {
  Answered answered = make_two_cells(9, 12, 0, 0);
  for (AnswerRow& row : answered.artifact) row.cell.clamp_level = 10;
  const auto result = answered.disturb({3, 20000, 20000}).front();
  ASSERT_EQ(result.under(Rule::kPaper).status, UncertaintyStatus::kNoCandidates);
  const double posterior = 1 - *eval_posterior_over({9, 12}), share = 1 - eval_upper_tail(9, 12, 9.0 / 12);
  for (const Rule rule : kRules) {
    const RuleUncertainty& under = result.under(rule);
    EXPECT_NEAR(*under.free_posterior, posterior, 4 * std::sqrt(posterior * (1 - posterior) / 20000));
    EXPECT_NEAR(*under.free_bootstrap, share, 4 * std::sqrt(share * (1 - share) / 20000));
    EXPECT_EQ(under.free_flips, (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
    EXPECT_FALSE(under.posterior || under.bootstrap);
    EXPECT_TRUE(under.artifact_flips.empty());
  }
  EXPECT_FALSE(make_two_cells(9, 12, 0, 14).disturb({3, 10, 10}).front().under(Rule::kPaper).free_posterior);
}

// C7 to C9 look free, C10 does not: `paper` finds no cut and pruning dropped the column. `isotonic` pools
// them to 9 of 48: free, and nobody was asked.
TEST(Uncertainty, of_a_dropped_column_is_told_rule_by_rule) {
  Answered answered;
  answered.study = load_protocol("pocket");
  const Column column = enumerate_columns(answered.study).front();
  for (int i = 0; i < 12; ++i) {
    for (const int level : {7, 8, 9, 10})
      answered.artifact.push_back({i + 1, i, {column, level, false}, level == 10 && i < 9});
  }
  answered.selection = make_selection(answered.study, tally_answers(answered.artifact, answered.study),
                                      SubjectKind::kPlanted, Rule::kPaper, std::string(64, 'a'));
  ASSERT_TRUE(answered.selection->columns.front().levels.empty());
  const ColumnFinding finding = answered.find().front();
  EXPECT_EQ(finding.under(Rule::kPaper).verdict, Verdict::kNone);
  EXPECT_EQ(finding.under(Rule::kIsotonic).verdict, Verdict::kUntested);
  const auto result = answered.disturb({1, 200, 200}).front();
  EXPECT_EQ(result.under(Rule::kPaper).status, UncertaintyStatus::kNoCandidates);
  EXPECT_EQ(result.under(Rule::kIsotonic).status, UncertaintyStatus::kDropped);
  EXPECT_FALSE(result.under(Rule::kIsotonic).posterior || result.under(Rule::kIsotonic).bootstrap);
  EXPECT_GT(*result.under(Rule::kIsotonic).free_posterior, 0.99);
  EXPECT_LT(*result.under(Rule::kPaper).free_posterior, 0.9);
  answered.selection.reset();
  EXPECT_EQ(answered.disturb({1, 10, 10}).front().under(Rule::kIsotonic).status, UncertaintyStatus::kUntested)
      << "not pruned yet";
}

// Seed 7: rows shuffled, subjects renamed and exchanged, the same numbers to the last bit.
TEST(Uncertainty, is_the_same_under_permutation_of_rows_and_of_subjects) {
  Answered answered = from(make_planted_study("pocket", 12, 14, 6, 0.1));
  const auto before = answered.disturb({7, 200, 200});
  RandomStream random(7, "permutation", 0);
  shuffle(answered.artifact, random);
  shuffle(answered.material, random);
  for (AnswerRow& row : answered.artifact) row.session = row.subject_index = 100 - row.session;
  const auto after = answered.disturb({7, 200, 200});
  for (std::size_t c = 0; c < before.size(); ++c) {
    for (const Rule rule : kRules) {
      const RuleUncertainty &a = before[c].under(rule), &b = after[c].under(rule);
      EXPECT_EQ(a.posterior, b.posterior);
      EXPECT_EQ(a.bootstrap, b.bootstrap);
      EXPECT_EQ(a.artifact_cut, b.artifact_cut);
      EXPECT_EQ(a.material_cut, b.material_cut);
      EXPECT_EQ(a.artifact_flips.size(), b.artifact_flips.size());
    }
  }
}

TEST(Uncertainty, is_the_same_on_any_number_of_threads) {
  const Answered answered = from(make_planted_study("pocket", 12, 14, 6, 0.3));
  const auto resample = [&](int threads) {
    return find_uncertainty(answered.study, answered.find(), make_response_matrix(answered.artifact),
                            make_response_matrix(answered.material), {3, 50, 101, threads});
  };
  const Uncertainty one = resample(1);
  for (const int threads : {2, 3, 64}) {
    const Uncertainty more = resample(threads);
    EXPECT_EQ(more.resamples, one.resamples) << threads;
    for (std::size_t c = 0; c < one.columns.size(); ++c) {
      for (const Rule rule : kRules) {
        EXPECT_EQ(more.columns[c].under(rule).bootstrap, one.columns[c].under(rule).bootstrap);
        EXPECT_EQ(more.columns[c].under(rule).artifact_cut, one.columns[c].under(rule).artifact_cut);
        EXPECT_EQ(more.columns[c].under(rule).material_cut, one.columns[c].under(rule).material_cut);
      }
    }
  }
}

TEST(Uncertainty, depends_on_its_seed) {
  const Answered answered = from(make_planted_study("pocket", 12, 14, 6, 0.3));
  const auto first = answered.disturb({1, 200, 200}), second = answered.disturb({2, 200, 200});
  bool differs = false;
  for (std::size_t c = 0; c < first.size(); ++c) {
    differs |= first[c].under(Rule::kPaper).bootstrap != second[c].under(Rule::kPaper).bootstrap;
  }
  EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace equilux::tests
