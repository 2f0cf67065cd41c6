// The rules of the study to the letter. C0 is the least clamped level, C10 the most.
#include "analysis/thresholds.h"

#include <algorithm>
#include <boost/container/small_vector.hpp>

#include "base/error.h"

namespace equilux {
namespace {

// A column is judged millions of times: what is as long as the scale takes no memory of the heap.
template <typename T>
using Levels = boost::container::small_vector<T, kClampLevelCount>;

Levels<std::size_t> find_tested(const ColumnCounts& counts) {
  Levels<std::size_t> tested;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i].count.n > 0) tested.push_back(i);
  }
  return tested;
}

Count add(const Count& a, const Count& b) { return {a.k + b.k, a.n + b.n}; }

// k_a / n_a > k_b / n_b, in integers.
bool is_above(const Count& a, const Count& b) { return a.k * b.n > b.k * a.n; }

// Whether the later, more clamped count breaks the order that the experiment expects.
bool is_violation(const Count& earlier, const Count& later, Experiment experiment) {
  return experiment == Experiment::kArtifact ? is_above(later, earlier) : is_above(earlier, later);
}

template <typename Breaks>
bool has_no_break(const ColumnCounts& counts, const Breaks& breaks) {
  const auto tested = find_tested(counts);
  for (std::size_t i = 1; i < tested.size(); ++i) {
    if (breaks(counts[tested[i - 1]].count, counts[tested[i]].count)) return false;
  }
  return true;
}

bool are_proportions_monotone(const ColumnCounts& counts, Experiment experiment) {
  return has_no_break(counts, [&](const Count& earlier, const Count& later) {
    return is_violation(earlier, later, experiment);
  });
}

bool are_flags_monotone(const ColumnCounts& counts, Experiment experiment, int percent) {
  return has_no_break(counts, [&](const Count& earlier, const Count& later) {
    return experiment == Experiment::kArtifact ? !is_flagged(earlier, percent) && is_flagged(later, percent)
                                               : is_flagged(earlier, percent) && !is_flagged(later, percent);
  });
}

void fill_states(Threshold& threshold, std::size_t begin, std::size_t end, LevelState state) {
  for (std::size_t i = begin; i < end; ++i) threshold.states[i] = state;
}

// Untested levels less clamped than the cut count as artifacts, more clamped ones as free.
Threshold cut_artifacts(const ColumnCounts& counts, int percent) {
  Threshold threshold;
  threshold.states.assign(counts.size(), LevelState::kUnknown);
  const auto tested = find_tested(counts);
  if (tested.empty()) return threshold;
  const auto last_flagged = std::find_if(tested.rbegin(), tested.rend(),
                                         [&](std::size_t i) { return is_flagged(counts[i].count, percent); });
  const std::size_t first_free = last_flagged == tested.rend() ? tested.front() : *last_flagged + 1;
  fill_states(threshold, 0, first_free, LevelState::kDifferent);
  fill_states(threshold, first_free, counts.size(), LevelState::kSame);
  if (first_free < counts.size()) threshold.cut = counts[first_free].level;
  threshold.status = first_free == counts.size()    ? CutStatus::kNone
                     : first_free == tested.front() ? CutStatus::kCensoredLow
                     : first_free > tested.back()   ? CutStatus::kCensoredHigh
                                                    : CutStatus::kCut;
  return threshold;
}

// Unchanged from the first tested level to the last tested one before the first changed; changed from there
// on. An untested level is unchanged only between two unchanged tested ones. Where the first tested level has
// changed, nothing is known of those below it.
Threshold cut_material(const ColumnCounts& counts, int percent) {
  Threshold threshold;
  threshold.states.assign(counts.size(), LevelState::kUnknown);
  const auto tested = find_tested(counts);
  if (tested.empty()) return threshold;
  const auto changed = std::find_if(tested.begin(), tested.end(),
                                    [&](std::size_t i) { return is_flagged(counts[i].count, percent); });
  if (changed != tested.end()) fill_states(threshold, *changed, counts.size(), LevelState::kDifferent);
  if (changed == tested.begin()) {
    threshold.status = tested.front() == 0 ? CutStatus::kNone : CutStatus::kCensoredLow;
    if (tested.front() > 0) threshold.below = counts[tested.front()].level;
    return threshold;
  }
  const std::size_t last_same = *std::prev(changed);
  fill_states(threshold, tested.front(), last_same + 1, LevelState::kSame);
  threshold.cut = counts[last_same].level;
  threshold.status = changed == tested.end() ? CutStatus::kCensoredHigh : CutStatus::kCut;
  return threshold;
}

}  // namespace

bool is_at_scale_end(const Threshold& threshold, Experiment experiment, const ColumnCounts& counts) {
  if (experiment == Experiment::kArtifact)
    return threshold.status == CutStatus::kCensoredLow && threshold.cut == counts.front().level;
  return threshold.status == CutStatus::kCensoredHigh && threshold.cut == counts.back().level;
}

std::string format_rule(Rule rule) { return rule == Rule::kPaper ? "paper" : "isotonic"; }

Rule parse_rule(std::string_view text, std::string_view source, std::string_view place) {
  for (const Rule rule : kRules) {
    if (text == format_rule(rule)) return rule;
  }
  throw InputError(source, place, "paper or isotonic", fmt::format("\"{}\"", text.substr(0, 80)));
}

std::string format_status(CutStatus status) {
  switch (status) {
    case CutStatus::kCut:
      return "cut";
    case CutStatus::kCensoredLow:
      return "censored_low";
    case CutStatus::kCensoredHigh:
      return "censored_high";
    case CutStatus::kNone:
      return "none";
    case CutStatus::kUntested:
      break;
  }
  return "untested";
}

std::string describe_status(const Threshold& threshold, Experiment experiment, const ColumnCounts& counts) {
  return is_at_scale_end(threshold, experiment, counts) ? "end of the scale"
                                                        : format_status(threshold.status);
}

std::string format_cut(const Threshold& threshold) {
  if (threshold.cut) return format_clamp(*threshold.cut);
  return threshold.below ? "< " + format_clamp(*threshold.below) : "-";
}

ColumnCounts pool_adjacent_violators(const ColumnCounts& counts, Experiment experiment) {
  struct Pool {
    Count sum;
    std::size_t members;  // neighbours among the tested levels
  };
  const auto tested = find_tested(counts);
  Levels<Pool> pools;
  for (const std::size_t i : tested) {
    pools.push_back({counts[i].count, 1});
    while (pools.size() > 1 && is_violation(pools[pools.size() - 2].sum, pools.back().sum, experiment)) {
      const Pool merged = pools.back();
      pools.pop_back();
      pools.back().sum = add(pools.back().sum, merged.sum);
      pools.back().members += merged.members;
    }
  }
  ColumnCounts pooled = counts;
  auto member = tested.begin();
  for (const Pool& pool : pools) {
    for (std::size_t i = 0; i < pool.members; ++i) pooled[*member++].count = pool.sum;
  }
  return pooled;
}

Threshold find_cut(const ColumnCounts& counts, Experiment experiment, Rule rule, int percent) {
  const bool pools = rule == Rule::kIsotonic;
  const ColumnCounts pooled = pools ? pool_adjacent_violators(counts, experiment) : ColumnCounts{};
  const ColumnCounts& judged = pools ? pooled : counts;
  return experiment == Experiment::kArtifact ? cut_artifacts(judged, percent) : cut_material(judged, percent);
}

Threshold find_threshold(const ColumnCounts& counts, Experiment experiment, Rule rule, int percent) {
  EQ_CHECK(std::is_sorted(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.level < b.level; }));
  Threshold threshold = find_cut(counts, experiment, rule, percent);
  threshold.monotone = are_proportions_monotone(counts, experiment);
  threshold.flags_monotone = are_flags_monotone(counts, experiment, percent);
  return threshold;
}

}  // namespace equilux
