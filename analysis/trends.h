// Whether equivalence grows or shrinks along a factor: an exact test, an effect with its interval, a
// sentence.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/probability.h"
#include "analysis/uncertainty.h"

namespace equilux {

/// Why a trend may have no test.
enum class TrendStatus {
  kTested,
  kNoPairs,        ///< the study has no columns that differ in this factor alone and have a verdict
  kFlat,           ///< EE never differs between them: nothing could be seen, p is 1
  kTooFewSubjects  ///< fewer than kLeastResampled: p is of the verdicts, and there is no interval
};

/// EE along levels of one factor, everything else equal. A stratum is a set of columns that differ in that
/// factor alone, in the order of its levels.
struct Trend {
  std::string factor;  ///< vpls, geometry, material, illumination, study
  std::string from;    ///< first level
  std::string to;      ///< last level; more than two are named by their ends
  TrendStatus status = TrendStatus::kNoPairs;
  std::int64_t strata = 0;
  std::int64_t gained = 0;  ///< pairs of a stratum with EE at the later level only
  std::int64_t lost = 0;    ///< with EE at the earlier level only
  std::int64_t pairs = 0;
  std::int64_t clusters = 0;     ///< objects that the pairs are of, at one VPL count or several
  std::optional<double> effect;  ///< (gained - lost) / pairs, -1 to 1: probability that EE is won less lost
  /// Of the effect: it, give or take the farther end of the report's resamples of subjects. A column that was
  /// dropped, and in a resample would not be, counts there as what takes the effect farther.
  std::optional<Interval> interval;
  double p = 1;        ///< two-sided, exact: the verdicts of each object permuted together (permutation.h)
  double p_least = 1;  ///< the least p that any verdicts of these columns could give
  double p_holm = 1;   ///< the same after Holm, over the trends of a report that compare something
  bool holds = false;  ///< p_holm <= kTrendLevel and the interval leaves out 0
};

inline constexpr double kTrendLevel = 0.05;

/// Trends along VPL counts (all, and each step), the blobs G0, G1, ... (other geometries have no order), the
/// material steps MS-MR, MS-BS, BS-BR and BS-GS, and illumination. Columns without a verdict count in no
/// pair. source: Jonckheere's statistic within strata, Holm 1979.
std::vector<Trend> find_trends(const Study& study, const std::vector<ColumnFinding>& findings, Rule rule,
                               const Uncertainty& uncertainty);

/// A study whose columns are compared with those of the same name in another.
struct ComparedStudy {
  std::string name;
  const std::vector<ColumnFinding>& findings;
  const Uncertainty& uncertainty;
};

/// EE from one study to another, as from plain to normalised pictures: factor `study`, a pair for each column
/// that both have. Subjects of the two are not paired. Both need as many resamples. p_holm is p;
/// adjust_trends allows for others.
Trend compare_studies(const ComparedStudy& from, const ComparedStudy& to, Rule rule);

/// Sets p_holm and holds of trends that are read together.
void adjust_trends(std::vector<Trend>& trends);

/// Adjusted p-values, in the order given. source: Holm 1979; R's p.adjust(p, "holm").
std::vector<double> adjust_holm(const std::vector<double>& p_values);

/// "With more VPLs (1k to 5M) equivalence was gained in 8 pairs and lost in none of 40 ..."
std::string describe_trend(const Trend& trend);

std::string format_trend_status(TrendStatus status);

}  // namespace equilux
