// How often intervals over subjects hold the truth: studies are simulated from proportions that are known.
// The shares stand in docs/analysis.md, well covered or not, and are printed; an interval a fifth narrower
// must not give them.
#include <algorithm>
#include <array>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <ostream>

#include "analysis/subjects.h"
#include "analysis/trends.h"
#include "analysis/uncertainty.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

constexpr double kNarrower = 0.8;

// Within three standard errors of a share of so many studies; of one of all, within three studies.
bool is_share(double share, int held, int studies) {
  const double error = std::sqrt(std::max(share * (1 - share), 1.0 / studies) / studies);
  return std::abs(static_cast<double>(held) / studies - share) <= 3 * error;
}

void print_share(const std::string& of, int held, int studies) {
  fmt::print("{}: {:.3f} of {} studies\n", of, static_cast<double>(held) / studies, studies);
}

bool holds(const std::optional<Interval>& interval, double truth) {
  constexpr double kRounding = 1e-12;
  return interval && interval->lower - kRounding <= truth && truth <= interval->upper + kRounding;
}

// About its estimate.
std::optional<Interval> make_narrower(const std::optional<Interval>& interval, double estimate) {
  if (!interval) return std::nullopt;
  return Interval{estimate + kNarrower * (interval->lower - estimate),
                  estimate + kNarrower * (interval->upper - estimate)};
}

// The level at which a normal interval is a fifth narrower.
double find_narrower_level() {
  const boost::math::normal normal;
  return 1 - 2 * cdf(normal, kNarrower * quantile(normal, (1 - kIntervalLevel) / 2));
}

template <typename Case>
std::string name_of_case(const ::testing::TestParamInfo<Case>& test) {
  return test.param.name;
}

// A cell, and the probability that a subject is correct in it.
struct Chance {
  Cell cell;
  double correct = 0;
};

std::vector<AnswerRow> answer_by_chance(const std::vector<Chance>& chances, Experiment experiment,
                                        int subjects, std::uint64_t seed) {
  std::vector<AnswerRow> answers;
  for (int subject = 0; subject < subjects; ++subject) {
    RandomStream random(seed, "coverage/" + format_experiment(experiment),
                        static_cast<std::uint64_t>(subject));
    for (const Chance& chance : chances)
      answers.push_back({subject + 1, subject, chance.cell, random.next_double() < chance.correct});
  }
  return answers;
}

// Of the columns that were asked: resampling the others takes time.
struct Simulated {
  std::vector<ColumnFinding> findings;
  Uncertainty uncertainty;
};

struct Chances {
  std::vector<Chance> artifact, material;
};

std::vector<ColumnFinding> find_asked(const Study& study, const Tally& artifact, const Tally& material) {
  auto findings = find_equivalence(study, artifact, material, nullptr);
  std::erase_if(findings, [](const ColumnFinding& finding) {
    return finding.under(Rule::kPaper).artifact.status == CutStatus::kUntested;
  });
  return findings;
}

// What as many subjects as one likes would find.
Tally tally_truth(const Study& study, const std::vector<Chance>& chances) {
  constexpr std::int64_t kMany = 1000000;
  Tally tally = tally_answers({}, study);
  for (const Chance& chance : chances)
    tally[chance.cell] = {std::llround(chance.correct * static_cast<double>(kMany)), kMany};
  return tally;
}

// 12 subjects see artifacts, 14 materials.
Simulated simulate_study(const Study& study, const Chances& chances, std::uint64_t seed,
                         const UncertaintyParams& params) {
  const auto seen = answer_by_chance(chances.artifact, Experiment::kArtifact, 12, seed);
  const auto changed = answer_by_chance(chances.material, Experiment::kMaterial, 14, seed);
  Simulated result;
  result.findings = find_asked(study, tally_answers(seen, study), tally_answers(changed, study));
  result.uncertainty = find_uncertainty(study, result.findings, make_response_matrix(seen),
                                        make_response_matrix(changed), params);
  return result;
}

// A column of four tested levels, whose true proportion is 75 % or more in the first `seen` of them: with all
// four the cut lies beyond them, of materials below C4.
struct CutCase {
  const char* name;
  std::vector<double> correct;  ///< from the level where most see something to the one where fewest do
  int seen = 0;
  bool tells_narrower = false;  ///< else a range over whole levels holds the cut as often
  double artifact[2];           ///< shares of ranges that hold the true cut; shape: in order of kRules
  double material[2];
};
void PrintTo(const CutCase& truth, std::ostream* out) { *out << truth.name; }

constexpr int kCutStudies = 1000;

// Artifacts fall with clamp: C3 to C6. Material changes rise: C4, C6, C8, C10.
Chances make_column_chances(const CutCase& truth, const Column& column) {
  Chances chances;
  for (int i = 0; i < 4; ++i) {
    const double correct = truth.correct[static_cast<std::size_t>(i)];
    chances.artifact.push_back({{column, 3 + i, false}, correct});
    chances.material.push_back({{column, 10 - 2 * i, false}, correct});
  }
  return chances;
}

// How many ranges hold the cut. shape: artifact, material; in order of kRules.
using HeldCuts = std::array<std::array<int, 2>, 2>;

HeldCuts count_held_cuts(const Study& study, const Chances& chances, int free, int same, double level) {
  HeldCuts held{};
  const auto holds = [](const std::optional<CutRange>& range, int cut) {
    return range && range->lower <= cut && cut <= range->upper;
  };
  for (std::uint64_t seed = 1; seed <= kCutStudies; ++seed) {
    const Uncertainty found = simulate_study(study, chances, seed, {1, 1, 400, 1, level}).uncertainty;
    for (std::size_t r = 0; r < 2; ++r) {
      held[0][r] += holds(found.columns[0].by_rule[r].artifact_cut, free) ? 1 : 0;
      held[1][r] += holds(found.columns[0].by_rule[r].material_cut, same) ? 1 : 0;
    }
  }
  return held;
}

class CutCoverage : public ::testing::TestWithParam<CutCase> {};

// Seeds 1..1000, 400 resamples each; three standard errors of the share.
TEST_P(CutCoverage, is_as_stated) {
  const CutCase& truth = GetParam();
  const Study study = load_protocol("pocket");
  const Chances chances = make_column_chances(truth, enumerate_columns(study).front());
  const int free = 3 + truth.seen, same = 10 - 2 * truth.seen;
  const auto count = [&](double level) { return count_held_cuts(study, chances, free, same, level); };
  const HeldCuts held = count(kIntervalLevel);
  const HeldCuts mutant = truth.tells_narrower
                              ? count(find_narrower_level())
                              : count_held_cuts(study, chances, free + 2, same - 4, kIntervalLevel);
  for (const Rule rule : kRules) {
    const auto r = static_cast<std::size_t>(rule);
    for (const std::size_t e : {0U, 1U}) {
      const double share = e == 0 ? truth.artifact[r] : truth.material[r];
      const std::string of =
          fmt::format("cut {} {} {}", truth.name, e == 0 ? "artifact" : "material", format_rule(rule));
      print_share(of, held[e][r], kCutStudies);
      EXPECT_TRUE(is_share(share, held[e][r], kCutStudies)) << of << ", stated " << share;
      EXPECT_FALSE(is_share(share, mutant[e][r], kCutStudies))
          << of << (truth.tells_narrower ? ", a fifth narrower" : ", two tested levels off");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Of, CutCoverage,
    ::testing::Values(CutCase{"step", {0.95, 0.85, 0.6, 0.5}, 2, false, {0.995, 0.995}, {1, 1}},
                      CutCase{"fading", {0.84, 0.78, 0.72, 0.66}, 2, true, {0.982, 0.981}, {0.988, 0.986}},
                      CutCase{"beyond", {0.95, 0.92, 0.9, 0.88}, 4, false, {1, 1}, {1, 1}},
                      CutCase{"brink", {0.74, 0.74, 0.74, 0.74}, 0, true, {0.8, 0.8}, {0.847, 0.847}}),
    name_of_case<CutCase>);

// EE of 24 columns of the main study: MS and MR on four geometries at three VPL counts, indirect-only.
struct TrendCase {
  const char* name;
  double spread = 0;  ///< of what is seen, in clamp levels
  int smooth[2];      ///< levels from artifact to material cut, negative without EE: of MS, pairs in turn
  int rough[2];       ///< the same of MR
  bool tells_narrower = false;
  double effect = 0;  ///< of the true proportions
  double shares[2];   ///< of intervals that hold it; shape: in order of kRules
};
void PrintTo(const TrendCase& truth, std::ostream* out) { *out << truth.name; }

double see(double distance, double spread) { return 0.5 + 0.48 / (1 + std::exp(-distance / spread)); }

void add_column(Chances& chances, const Column& column, int margin, double spread) {
  constexpr int kFree = 4;  // artifact cut
  for (int level = kFree - 2; level < kFree + 2; ++level)
    chances.artifact.push_back({{column, level, false}, see(kFree - 0.5 - level, spread)});
  for (int level = kFree; level <= 10; level += 2)
    chances.material.push_back({{column, level, false}, see(level - kFree - margin - 0.5, spread)});
}

Chances make_trend_chances(const TrendCase& truth, const Study& study) {
  Chances chances;
  std::size_t smooth = 0, rough = 0;
  for (const Column& column : enumerate_columns(study)) {
    if (column.object.illumination != Illumination::kIndirect) continue;
    if (column.object.material == "MS") add_column(chances, column, truth.smooth[smooth++ % 2], truth.spread);
    if (column.object.material == "MR") add_column(chances, column, truth.rough[rough++ % 2], truth.spread);
  }
  return chances;
}

Trend find_step(const Study& study, const Simulated& simulated, Rule rule) {
  const auto trends = find_trends(study, simulated.findings, rule, simulated.uncertainty);
  return *std::find_if(trends.begin(), trends.end(), [](const Trend& trend) { return trend.to == "MR"; });
}

class TrendCoverage : public ::testing::TestWithParam<TrendCase> {};

// Seeds 1..150, 200 resamples each; three standard errors of the share.
TEST_P(TrendCoverage, is_as_stated) {
  constexpr int kStudies = 150;
  const TrendCase& truth = GetParam();
  const Study study = load_protocol("paper");
  const Chances chances = make_trend_chances(truth, study);
  const auto findings =
      find_asked(study, tally_truth(study, chances.artifact), tally_truth(study, chances.material));
  for (const Rule rule : kRules)
    EXPECT_EQ(find_step(study, {findings, {}}, rule).effect, truth.effect) << "of the true proportions";
  std::array<int, 2> held{}, narrow{};
  std::array<double, 2> mean{};
  for (std::uint64_t seed = 1; seed <= kStudies; ++seed) {
    const Simulated simulated = simulate_study(study, chances, seed, {1, 1, 200, 1});
    for (const Rule rule : kRules) {
      const Trend step = find_step(study, simulated, rule);
      const auto r = static_cast<std::size_t>(rule);
      mean[r] += *step.effect / kStudies;
      held[r] += holds(step.interval, truth.effect) ? 1 : 0;
      narrow[r] += holds(make_narrower(step.interval, *step.effect), truth.effect) ? 1 : 0;
    }
  }
  for (const Rule rule : kRules) {
    const auto r = static_cast<std::size_t>(rule);
    const std::string of = fmt::format("trend {} {} (true {:.2f}, found {:.2f} on average)", truth.name,
                                       format_rule(rule), truth.effect, mean[r]);
    print_share(of, held[r], kStudies);
    EXPECT_TRUE(is_share(truth.shares[r], held[r], kStudies)) << of << ", stated " << truth.shares[r];
    if (truth.tells_narrower) {
      EXPECT_FALSE(is_share(truth.shares[r], narrow[r], kStudies)) << of << ", a fifth narrower";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Of, TrendCoverage,
                         ::testing::Values(TrendCase{"none", 0.1, {3, -2}, {3, -2}, false, 0, {1, 1}},
                                           TrendCase{"half", 0.1, {3, -2}, {3, 3}, false, 0.5, {1, 1}},
                                           TrendCase{"whole", 0.1, {-2, -2}, {3, 3}, false, 1, {1, 1}},
                                           TrendCase{"fading", 1, {-2, -2}, {3, 3}, true, 1, {0.98, 0.993}},
                                           TrendCase{"faint", 2, {-2, -2}, {3, 3}, true, 1, {0.8, 0.913}}),
                         name_of_case<TrendCase>);

// Sessions of 60 trials a half; what a subject loses in the second half differs between subjects.
struct OrderCase {
  const char* name;
  int subjects = 0;
  double losers = 0;  ///< share of subjects who lose `loss`; the others lose nothing
  double loss = 0;
  double share = 0;  ///< of intervals that hold the true mean
};
void PrintTo(const OrderCase& truth, std::ostream* out) { *out << truth.name; }

SessionSummary simulate_session(const OrderCase& truth, RandomStream& random) {
  const double first = 0.8, second = first - (random.next_double() < truth.losers ? truth.loss : 0);
  SessionSummary summary;
  summary.complete = true;
  for (int trial = 0; trial < 60; ++trial) {
    summary.first_half.k += random.next_double() < first ? 1 : 0;
    summary.second_half.k += random.next_double() < second ? 1 : 0;
  }
  summary.first_half.n = summary.second_half.n = 60;
  return summary;
}

class OrderCoverage : public ::testing::TestWithParam<OrderCase> {};

// Seeds 1..1000; three standard errors of the share.
TEST_P(OrderCoverage, is_as_stated) {
  constexpr int kStudies = 1000;
  const OrderCase& truth = GetParam();
  const double mean = -truth.losers * truth.loss;
  int held = 0, narrow = 0;
  for (std::uint64_t seed = 1; seed <= kStudies; ++seed) {
    RandomStream random(seed, "coverage/order", 0);
    std::vector<SessionSummary> summaries;
    for (int i = 0; i < truth.subjects; ++i) summaries.push_back(simulate_session(truth, random));
    const OrderEffect effect = find_order_effect(summaries, seed);
    held += holds(effect.interval, mean) ? 1 : 0;
    narrow += holds(make_narrower(effect.interval, *effect.correct), mean) ? 1 : 0;
  }
  print_share(fmt::format("order {}", truth.name), held, kStudies);
  EXPECT_TRUE(is_share(truth.share, held, kStudies)) << "stated " << truth.share;
  EXPECT_FALSE(is_share(truth.share, narrow, kStudies)) << "a fifth narrower";
}

INSTANTIATE_TEST_SUITE_P(Of, OrderCoverage,
                         ::testing::Values(OrderCase{"alike", 12, 0, 0, 0.95},
                                           OrderCase{"half_tire", 12, 0.5, 0.2, 0.95},
                                           OrderCase{"few_tire", 12, 0.15, 0.3, 0.93}),
                         name_of_case<OrderCase>);

}  // namespace
}  // namespace equilux::tests
