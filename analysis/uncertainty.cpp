// Three ways to disturb the counts, one way to judge them.
#include "analysis/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <map>
#include <numeric>
#include <thread>
#include <utility>

#include "analysis/posterior.h"
#include "analysis/probability.h"
#include "base/error.h"
#include "base/random.h"

namespace equilux {
namespace {

// A column of one experiment whose counts can be replaced without looking for its cells again.
struct Slots {
  ColumnCounts counts;
  std::vector<std::pair<std::size_t, std::size_t>> cells;  // place in counts, place in the matrix

  void fill(const std::vector<Count>& by_cell) {
    for (const auto& [level, cell] : cells) counts[level].count = by_cell[cell];
  }
};

Slots make_slots(const ColumnCounts& counts, const Column& column, bool normalised,
                 const ResponseMatrix& matrix) {
  Slots slots{counts, {}};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const Cell cell{column, counts[i].level, normalised};
    const auto found = std::lower_bound(matrix.cells.begin(), matrix.cells.end(), cell);
    if (found == matrix.cells.end() || *found != cell) continue;
    slots.cells.emplace_back(i, static_cast<std::size_t>(found - matrix.cells.begin()));
  }
  return slots;
}

struct ColumnSlots {
  Slots artifact;
  Slots material;
  std::vector<int> levels;
};

// How often a cut was where, at least and at most clamped. shape: a place for no level before the first, one
// each, one beyond the last.
class CutHistogram {
 public:
  explicit CutHistogram(const std::vector<int>& levels)
      : levels_(levels), least_(levels.size() + 2, 0), most_(least_) {}

  void add(const Threshold& threshold, Experiment experiment) {
    if (threshold.status == CutStatus::kUntested) return;
    const std::size_t none = experiment == Experiment::kArtifact ? least_.size() - 1 : 0;
    const std::size_t place = threshold.cut ? place_of(*threshold.cut) : none;
    ++least_[place];
    ++most_[threshold.below ? place_of(*threshold.below) - 1 : place];
  }

  void add(const CutHistogram& other) {
    for (std::size_t place = 0; place < least_.size(); ++place) {
      least_[place] += other.least_[place];
      most_[place] += other.most_[place];
    }
  }

  std::optional<CutRange> find_range(double tail) const {
    const std::int64_t total = std::accumulate(least_.begin(), least_.end(), std::int64_t{0});
    if (total == 0) return std::nullopt;
    return CutRange{find_quantile(least_, tail, total), find_quantile(most_, 1 - tail, total)};
  }

 private:
  std::size_t place_of(int level) const {
    return static_cast<std::size_t>(std::find(levels_.begin(), levels_.end(), level) - levels_.begin()) + 1;
  }
  // Nearest rank.
  int find_quantile(const std::vector<std::int64_t>& counts, double share, std::int64_t total) const {
    const double rank = std::max(1.0, std::ceil(share * static_cast<double>(total)));
    std::int64_t below = 0;
    std::size_t place = 0;
    while (place + 1 < counts.size() && static_cast<double>(below += counts[place]) < rank) ++place;
    if (place == 0) return levels_.front() - 1;
    return place > levels_.size() ? levels_.back() + 1 : levels_[place - 1];
  }

  std::vector<int> levels_;
  std::vector<std::int64_t> least_, most_;
};

struct Thresholds {
  Threshold artifact;
  Threshold material;
};

Thresholds judge(const ColumnSlots& column, Rule rule) {
  return {find_cut(column.artifact.counts, Experiment::kArtifact, rule),
          find_cut(column.material.counts, Experiment::kMaterial, rule)};
}

std::vector<std::uint32_t> draw_subjects(std::size_t subjects, const std::string& stream, int resample,
                                         std::uint64_t seed) {
  RandomStream random(seed, stream, static_cast<std::uint64_t>(resample));
  std::vector<std::uint32_t> weights(subjects, 0);
  for (std::size_t i = 0; i < subjects; ++i) ++weights[random.next_below(subjects)];
  return weights;
}

// Of one column.
struct ResampleSums {
  std::array<Share, 2> shares = {};
  std::array<Share, 2> free = {};      // in which some level is free of artifacts
  std::vector<CutHistogram> artifact;  // shape: in order of kRules
  std::vector<CutHistogram> material;

  void add(const ResampleSums& other) {
    for (std::size_t r = 0; r < shares.size(); ++r) {
      shares[r].add(other.shares[r]);
      free[r].add(other.free[r]);
      artifact[r].add(other.artifact[r]);
      material[r].add(other.material[r]);
    }
  }
};

// Of resamples one after another.
struct ResampleRun {
  std::vector<ResampleSums> columns;
  std::array<std::vector<Resampled>, 2> verdicts;

  void append(const ResampleRun& next) {
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c].add(next.columns[c]);
    for (std::size_t r = 0; r < verdicts.size(); ++r)
      verdicts[r].insert(verdicts[r].end(), next.verdicts[r].begin(), next.verdicts[r].end());
  }
};

void add_resample(ResampleRun& run, std::vector<ColumnSlots>& columns, const std::vector<Count>& artifact,
                  const std::vector<Count>& material) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    columns[c].artifact.fill(artifact);
    columns[c].material.fill(material);
    ResampleSums& sums = run.columns[c];
    for (const Rule rule : kRules) {
      const auto r = static_cast<std::size_t>(rule);
      const Thresholds thresholds = judge(columns[c], rule);
      run.verdicts[r].push_back(judge_resample(thresholds.artifact, thresholds.material));
      sums.shares[r].add(run.verdicts[r].back());
      sums.free[r].add(judge_free(thresholds.artifact));
      sums.artifact[r].add(thresholds.artifact, Experiment::kArtifact);
      sums.material[r].add(thresholds.material, Experiment::kMaterial);
    }
  }
}

// Of an experiment of a study by itself: rows of two matrices stand in no pairs.
std::string name_stream(Experiment experiment, const std::string& study) {
  return fmt::format("analysis/bootstrap/{}/{}", format_experiment(experiment), study);
}

// Those from `first` to `end`.
ResampleRun resample(std::vector<ColumnSlots> columns, const std::string& study,
                     const ResponseMatrix& artifact, const ResponseMatrix& material, std::uint64_t seed,
                     int first, int end) {
  ResampleRun run;
  for (const ColumnSlots& column : columns) {
    const std::vector<CutHistogram> empty(2, CutHistogram(column.levels));
    run.columns.push_back({{}, {}, empty, empty});
  }
  for (int number = first; number < end; ++number) {
    const auto counts = [&](const ResponseMatrix& matrix, Experiment experiment) {
      return count_weighted(matrix,
                            draw_subjects(matrix.subjects(), name_stream(experiment, study), number, seed));
    };
    add_resample(run, columns, counts(artifact, Experiment::kArtifact),
                 counts(material, Experiment::kMaterial));
  }
  return run;
}

// Side by side: every resample has a stream of its own.
ResampleRun resample_all(const std::vector<ColumnSlots>& columns, const std::string& study,
                         const ResponseMatrix& artifact, const ResponseMatrix& material,
                         const UncertaintyParams& params) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const int threads = std::clamp(params.threads > 0 ? params.threads : cores, 1, params.resamples);
  const auto begin_of = [&](int thread) {
    return static_cast<int>(std::int64_t{params.resamples} * thread / threads);
  };
  std::vector<std::future<ResampleRun>> running;
  for (int thread = 0; thread < threads; ++thread) {
    running.push_back(std::async(std::launch::async, [&, thread] {
      return resample(columns, study, artifact, material, params.seed, begin_of(thread),
                      begin_of(thread + 1));
    }));
  }
  ResampleRun all = running.front().get();
  for (std::size_t thread = 1; thread < running.size(); ++thread) all.append(running[thread].get());
  return all;
}

// shape: a range for each rule, in order of kRules; too few subjects, drawn again, have none.
std::array<std::optional<CutRange>, 2> find_ranges(const std::vector<CutHistogram>& cuts,
                                                   std::size_t subjects, double level) {
  if (subjects < kLeastResampled) return {};
  const double tail = find_bootstrap_tail(subjects, level);
  std::optional<CutRange> paper = cuts[static_cast<std::size_t>(Rule::kPaper)].find_range(tail);
  const auto isotonic = cuts[static_cast<std::size_t>(Rule::kIsotonic)].find_range(tail);
  if (paper && isotonic)
    paper = {std::min(paper->lower, isotonic->lower), std::max(paper->upper, isotonic->upper)};
  return {paper, isotonic};
}

// Whether only the artifact answers say anything of EE.
bool is_unasked(UncertaintyStatus status) {
  return status == UncertaintyStatus::kNoCandidates || status == UncertaintyStatus::kDropped;
}

void take_sums(ColumnUncertainty& result, const ResampleSums& sums, std::size_t artifact,
               std::size_t material, double level) {
  const auto artifact_cuts = find_ranges(sums.artifact, artifact, level);
  const auto material_cuts = find_ranges(sums.material, material, level);
  for (std::size_t r = 0; r < result.by_rule.size(); ++r) {
    result.by_rule[r].artifact_cut = artifact_cuts[r];
    result.by_rule[r].material_cut = material_cuts[r];
    const UncertaintyStatus status = result.by_rule[r].status;
    if (is_resampled(status)) result.by_rule[r].bootstrap = sums.shares[r].get();
    if (is_unasked(status) && artifact > 1) result.by_rule[r].free_bootstrap = sums.free[r].get();
  }
}

// The counts without one subject.
std::vector<Count> subtract_subject(std::vector<Count> counts, const ResponseMatrix& matrix, std::size_t s) {
  const std::size_t width = matrix.cells.size();
  for (std::size_t c = 0; c < width; ++c) {
    counts[c].n -= matrix.asked[s * width + c];
    counts[c].k -= matrix.correct[s * width + c];
  }
  return counts;
}

bool is_exists(const ColumnSlots& column, Rule rule) {
  const Thresholds thresholds = judge(column, rule);
  return is_any_equivalent(thresholds.artifact, thresholds.material);
}

bool is_any_free(const ColumnSlots& column, Rule rule) {
  return judge_free(find_cut(column.artifact.counts, Experiment::kArtifact, rule)) == Resampled::kExists;
}

// The rows of a person in the two matrices.
struct Person {
  std::optional<std::size_t> artifact, material;
};

std::vector<Person> pair_persons(const ResponseMatrix& artifact, const ResponseMatrix& material) {
  std::map<std::string, std::size_t> by_code;
  std::vector<Person> persons(artifact.subjects());
  for (std::size_t s = 0; s < artifact.subjects(); ++s) {
    persons[s].artifact = s;
    if (!artifact.persons[s].empty()) by_code[artifact.persons[s]] = s;
  }
  for (std::size_t s = 0; s < material.subjects(); ++s) {
    const auto same = by_code.find(material.persons[s]);
    if (same == by_code.end()) {
      persons.push_back({std::nullopt, s});
    } else {
      persons[same->second].material = s;
    }
  }
  return persons;
}

// The counts of an experiment, and those without a subject.
struct LeaveOut {
  const ResponseMatrix& matrix;
  std::vector<Count> all = count_weighted(matrix, std::vector<std::uint32_t>(matrix.subjects(), 1));

  std::vector<Count> without(const std::optional<std::size_t>& subject) const {
    return subject ? subtract_subject(all, matrix, *subject) : all;
  }
};

void note_flip(RuleUncertainty& under, const Person& person, const ResponseMatrix& artifact,
               const ResponseMatrix& material) {
  if (person.artifact) {
    under.artifact_flips.push_back(artifact.sessions[*person.artifact]);
  } else {
    under.material_flips.push_back(material.sessions[*person.material]);
  }
}

// Notes whom the column's finding turns without: EE, or, where nobody was asked, whether a level is free.
void compare_without(ColumnUncertainty& result, const ColumnSlots& without, const ColumnSlots& whole,
                     const Person& person, const ResponseMatrix& artifact, const ResponseMatrix& material) {
  for (const Rule rule : kRules) {
    RuleUncertainty& under = result.by_rule[static_cast<std::size_t>(rule)];
    if (is_resampled(under.status)) {
      if (is_exists(without, rule) != is_exists(whole, rule)) note_flip(under, person, artifact, material);
    } else if (is_unasked(under.status) && person.artifact &&
               is_any_free(without, rule) != is_any_free(whole, rule)) {
      under.free_flips.push_back(artifact.sessions[*person.artifact]);
    }
  }
}

// Leaves each person out in turn, from both experiments.
void find_flips(std::vector<ColumnUncertainty>& results, std::vector<ColumnSlots> columns,
                const ResponseMatrix& artifact, const ResponseMatrix& material) {
  const LeaveOut seen{artifact}, changed{material};
  const std::vector<ColumnSlots> whole = columns;
  for (const Person& person : pair_persons(artifact, material)) {
    const std::vector<Count> seen_without = seen.without(person.artifact),
                             changed_without = changed.without(person.material);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      columns[c].artifact.fill(seen_without);
      columns[c].material.fill(changed_without);
      compare_without(results[c], columns[c], whole[c], person, artifact, material);
    }
  }
  for (ColumnUncertainty& result : results) {
    for (RuleUncertainty& under : result.by_rule) {
      std::sort(under.artifact_flips.begin(), under.artifact_flips.end());
      std::sort(under.material_flips.begin(), under.material_flips.end());
      std::sort(under.free_flips.begin(), under.free_flips.end());
    }
  }
}

UncertaintyStatus find_status(const ColumnFinding& finding, Rule rule, const ColumnSlots& column,
                              std::size_t artifact, std::size_t material) {
  if (column.artifact.cells.empty()) return UncertaintyStatus::kUntested;
  if (column.material.cells.empty()) {
    if (finding.under(rule).artifact.status == CutStatus::kNone) return UncertaintyStatus::kNoCandidates;
    return finding.dropped ? UncertaintyStatus::kDropped : UncertaintyStatus::kUntested;
  }
  const std::size_t least = std::min(artifact, material);
  if (least < 2) return UncertaintyStatus::kOneSubject;
  return least < kLeastResampled ? UncertaintyStatus::kTooFewSubjects : UncertaintyStatus::kEstimated;
}

void take_posteriors(ColumnUncertainty& result, const ColumnFinding& finding, const ColumnSlots& column,
                     const PosteriorParams& params) {
  const auto& by_rule = result.by_rule;
  if (std::any_of(by_rule.begin(), by_rule.end(), [](const auto& u) { return is_unasked(u.status); })) {
    const RuleShares free = find_free_posterior(finding, params);
    for (std::size_t r = 0; r < free.size(); ++r) {
      if (is_unasked(by_rule[r].status)) result.by_rule[r].free_posterior = free[r];
    }
  }
  if (column.artifact.cells.empty() || column.material.cells.empty()) return;
  const EquivalencePosterior posterior = find_posterior(finding, params);
  for (std::size_t r = 0; r < result.by_rule.size(); ++r) {
    result.by_rule[r].posterior = posterior.jeffreys[r];
    result.by_rule[r].posterior_above_half = posterior.above_half[r];
  }
}

std::vector<ColumnSlots> make_column_slots(const Study& study, const std::vector<ColumnFinding>& findings,
                                           const ResponseMatrix& artifact, const ResponseMatrix& material) {
  std::vector<ColumnSlots> columns;
  for (const ColumnFinding& finding : findings) {
    columns.push_back({make_slots(finding.artifact, finding.column, study.normalise, artifact),
                       make_slots(finding.material, finding.column, study.normalise, material),
                       study.clamp_levels});
  }
  return columns;
}

}  // namespace

Uncertainty find_uncertainty(const Study& study, const std::vector<ColumnFinding>& findings,
                             const ResponseMatrix& artifact, const ResponseMatrix& material,
                             const UncertaintyParams& params) {
  EQ_CHECK(params.posterior_draws > 0 && params.resamples > 0, params.posterior_draws, params.resamples);
  const std::vector<ColumnSlots> columns = make_column_slots(study, findings, artifact, material);
  Uncertainty result;
  result.columns.resize(findings.size());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    ColumnUncertainty& column = result.columns[c];
    for (const Rule rule : kRules)
      column.by_rule[static_cast<std::size_t>(rule)].status =
          find_status(findings[c], rule, columns[c], artifact.subjects(), material.subjects());
    take_posteriors(column, findings[c], columns[c], {params.seed, params.posterior_draws});
  }
  result.subjects = std::min(artifact.subjects(), material.subjects());
  ResampleRun run = resample_all(columns, study.name, artifact, material, params);
  if (artifact.subjects() > 1 && material.subjects() > 1) result.resamples = std::move(run.verdicts);
  for (std::size_t c = 0; c < columns.size(); ++c)
    take_sums(result.columns[c], run.columns[c], artifact.subjects(), material.subjects(), params.level);
  find_flips(result.columns, columns, artifact, material);
  return result;
}

bool is_resampled(UncertaintyStatus status) {
  return status == UncertaintyStatus::kEstimated || status == UncertaintyStatus::kTooFewSubjects;
}

std::string format_uncertainty_status(UncertaintyStatus status) {
  switch (status) {
    case UncertaintyStatus::kEstimated:
      return "estimated";
    case UncertaintyStatus::kOneSubject:
      return "one_subject";
    case UncertaintyStatus::kTooFewSubjects:
      return "too_few_subjects";
    case UncertaintyStatus::kNoCandidates:
      return "no_candidates";
    case UncertaintyStatus::kDropped:
      return "dropped";
    case UncertaintyStatus::kUntested:
      break;
  }
  return "untested";
}

}  // namespace equilux
