// What is known of a proportion after k of n: exact tails, intervals and the posterior.
#pragma once

#include <optional>
#include <vector>

#include "analysis/tally.h"

namespace equilux {

/// Probability of k or more of n at one half, the p_guess of cells.csv; empty where n = 0. Summed in integers
/// up to n = 62 and so the double nearest to the rational number; by the incomplete beta function beyond.
std::optional<double> eval_p_guess(const Count& count);

/// Probability at one half of a count at least as far from n / 2, either way; empty where n = 0.
/// source: R's binom.test(k, n)$p.value.
std::optional<double> eval_p_two_sided(const Count& count);

inline constexpr double kFlagProportion = 0.75;  ///< proportion correct at which a cell is flagged
inline constexpr double kSupportLevel = 0.05;    ///< one-sided error of a supported cell

/// True iff a true proportion of `percent` correct would give k or fewer with probability of at most
/// kSupportLevel: then the cell is shown to be below the cut (at 75 % k <= 5 of 12, k <= 7 of 14), not only
/// not shown to be above it.
bool is_supported(const Count& count, int percent = kFlagPercent);

/// units: proportion correct, 0 to 1.
struct Interval {
  double lower = 0;
  double upper = 1;
  bool operator==(const Interval&) const = default;
};

inline constexpr double kIntervalLevel = 0.95;  ///< of every two-sided interval that is reported

/// Interval that covers the true proportion at least at `level`, whatever it is. Empty where n = 0.
/// source: Clopper and Pearson 1934; R's binom.test(k, n)$conf.int.
std::optional<Interval> find_clopper_pearson(const Count& count, double level = kIntervalLevel);

/// Central interval of the posterior from Jeffreys' prior Beta(1/2, 1/2), the lower end 0 where k = 0 and the
/// upper end 1 where k = n. It covers at `level` on average. Empty where n = 0.
/// source: Brown, Cai and DasGupta 2001, section 3.2; R's qbeta(p, k + 1/2, n - k + 1/2).
std::optional<Interval> find_jeffreys(const Count& count, double level = kIntervalLevel);

/// Subjects of whom a bootstrap interval can be made: of fewer hardly any resample lies beyond its ends, so
/// that it goes from the least to the most of what was seen, and covers far less than its level (51 % of
/// means of two, 88 % of four).
inline constexpr std::size_t kLeastResampled = 6;

/// Share of resamples beyond either end of a bootstrap interval over so many subjects. More are left inside
/// than `level`, so that the interval of a mean is as wide as Student's: resamples of few vary too little.
/// source: Hesterberg 2015, What Teachers Should Know About the Bootstrap, the expanded percentile interval.
double find_bootstrap_tail(std::size_t subjects, double level = kIntervalLevel);

/// Posterior probability, from the same prior, that the true proportion is at least `proportion`. Empty where
/// n = 0: then nothing is known but the prior.
std::optional<double> eval_posterior_over(const Count& count, double proportion = kFlagProportion);

/// Smallest false-discovery rates at which each hypothesis would be rejected, in the order of `p_values`.
/// source: Benjamini and Hochberg 1995; R's p.adjust(p, "BH").
std::vector<double> adjust_false_discovery(const std::vector<double>& p_values);

}  // namespace equilux
