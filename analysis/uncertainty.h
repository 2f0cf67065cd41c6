// How sure cuts and verdicts are: posterior draws, subjects drawn again, and each subject left out in turn.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/equivalence.h"
#include "analysis/probability.h"
#include "analysis/resampled.h"
#include "analysis/response_matrix.h"

namespace equilux {

/// Defaults of a report; the first three stand in its outputs.
struct UncertaintyParams {
  std::uint64_t seed = 1;
  int posterior_draws = 2000;  ///< Monte Carlo error of a share: at most 0.011
  int resamples = 2000;        ///< of subjects
  int threads = 0;  ///< at most; 0: as many as there are cores. What comes out does not depend on it.
  double level = kIntervalLevel;  ///< of ranges of cuts
};

/// Of kLeastResampled subjects or more. Where a cut lies in all resamples but find_bootstrap_tail at either
/// end, as places on the scale of clamp levels. Under `paper` it is widened to the range under `isotonic`: of
/// many levels near the cut that rule takes the outermost that chance flags, and of a resample's again, so
/// that its own range drifts outwards.
struct CutRange {
  int lower = 0;  ///< a clamp level; -1: no level, before the first one (material). A material threshold
                  ///< below all tested levels may lie from there up to the level before them
  int upper = 0;  ///< a clamp level; one more than the last: no level, beyond it (artifact)
  bool operator==(const CutRange&) const = default;
};

/// Why a column's uncertainty under a rule may be missing.
enum class UncertaintyStatus {
  kEstimated,
  kUntested,        ///< an experiment has no answers in this column
  kOneSubject,      ///< one subject answered: drawing it again says nothing; only the posterior is given
  kTooFewSubjects,  ///< fewer than kLeastResampled in an experiment: shares and flips, but no range of its
                    ///< cuts
  kNoCandidates,  ///< every tested level has artifacts: EE is false, and nobody was asked about the material
  kDropped,       ///< the selection dropped the column, by another rule: under this one levels are free, and
                  ///< nobody was asked about their material. EE is untested.
};

/// Under one rule.
struct RuleUncertainty {
  UncertaintyStatus status = UncertaintyStatus::kUntested;
  std::optional<double> posterior;  ///< probability of EE, the cells' proportions drawn from their posteriors
  /// The same with Jeffreys' prior cut off below one half, where no proportion correct can lie.
  std::optional<double> posterior_above_half;
  std::optional<double> bootstrap;  ///< share of resamples in which EE is true
  std::optional<CutRange> artifact_cut;
  std::optional<CutRange> material_cut;
  /// Persons without whom the verdict is another, by their artifact session. A person of both experiments is
  /// left out of both. shape: ResponseMatrix::sessions, sorted.
  std::vector<std::int64_t> artifact_flips;
  std::vector<std::int64_t> material_flips;  ///< of those who have a material session alone, by that
  /// Of a column with kNoCandidates or kDropped: that some level is free of artifacts, as EE needs, by its
  /// artifact answers alone. EE is no more probable than that. Posterior probability and share of resamples.
  std::optional<double> free_posterior;
  std::optional<double> free_bootstrap;
  /// The same column's persons without whom one is free if none was, or none if one was; as artifact_flips.
  std::vector<std::int64_t> free_flips;
};

struct ColumnUncertainty {
  std::array<RuleUncertainty, 2> by_rule;  ///< shape: in order of kRules

  const RuleUncertainty& under(Rule rule) const { return by_rule[static_cast<std::size_t>(rule)]; }
};

struct Uncertainty {
  std::vector<ColumnUncertainty> columns;  ///< one for each finding, in its order
  /// EE of every resample, for what is computed over columns. shape: by rule in order of kRules; resamples x
  /// columns, row by row. Empty where an experiment has fewer than two subjects: drawn again, one says
  /// nothing.
  std::array<std::vector<Resampled>, 2> resamples;
  std::size_t subjects = 0;  ///< of the experiment that has fewer
};

/// Subjects are drawn with replacement, in each experiment of each study by itself, also where one person's
/// code stands in several: studies are told apart by their names; flagged cells of a draw go through the same
/// column rules as counts. The same answers and seed give the same numbers in whatever order they come.
/// source: Efron and Tibshirani 1993, chapters 6, 11 and 13.
Uncertainty find_uncertainty(const Study& study, const std::vector<ColumnFinding>& findings,
                             const ResponseMatrix& artifact, const ResponseMatrix& material,
                             const UncertaintyParams& params);

/// Whether subjects could be drawn again and left out: bootstrap and flips are given.
bool is_resampled(UncertaintyStatus status);

std::string format_uncertainty_status(UncertaintyStatus status);

}  // namespace equilux
