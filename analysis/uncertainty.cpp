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
#include "analysis/weighted_counts.h"
#include "base/below.h"
#include "base/error.h"
#include "base/random_run.h"

namespace equilux {
namespace {

// A column of one experiment whose counts can be replaced without looking for its cells again.
struct Slots {
  std::vector<Count> counts;                               // one for each clamp level
  std::vector<std::pair<std::size_t, std::size_t>> cells;  // place in counts, place in the matrix

  // `count_of` gives the count of a cell by its place in the matrix.
  void fill(const auto& count_of) {
    for (const auto& [level, cell] : cells) counts[level] = count_of(cell);
  }
};

Slots make_slots(const ColumnCounts& column_counts, const Column& column, bool normalised,
                 const ResponseMatrix& matrix) {
  Slots slots;
  for (const LevelCount& level : column_counts) {
    const Cell cell{column, level.level, normalised};
    const auto found = std::lower_bound(matrix.cells.begin(), matrix.cells.end(), cell);
    slots.counts.push_back(level.count);
    if (found == matrix.cells.end() || *found != cell) continue;
    slots.cells.emplace_back(slots.counts.size() - 1, static_cast<std::size_t>(found - matrix.cells.begin()));
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

  // An artifact cut is at the first level that is free, beyond the last one where none is; a material cut at
  // the last unchanged level, before the first one where none is, or anywhere below the first changed one
  // where no level below was tested.
  void add(const PlacedCut& cut, Experiment experiment) {
    if (cut.status == CutStatus::kUntested) return;
    const bool is_artifact = experiment == Experiment::kArtifact;
    const std::size_t place = is_artifact ? cut.same.begin + std::size_t{1} : cut.same.end;
    ++least_[place];
    ++most_[!is_artifact && cut.status == CutStatus::kCensoredLow ? cut.different.begin : place];
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

// Under both rules, in order of kRules.
struct ColumnCuts {
  std::array<PlacedCut, 2> artifact, material;
};

ColumnCuts judge(const ColumnSlots& column) {
  return {place_cuts(column.artifact.counts, Experiment::kArtifact),
          place_cuts(column.material.counts, Experiment::kMaterial)};
}

// Of an experiment of a study by itself: rows of two matrices stand in no pairs.
std::string name_stream(Experiment experiment, const std::string& study) {
  return fmt::format("analysis/bootstrap/{}/{}", format_experiment(experiment), study);
}

// An experiment whose subjects can be drawn again.
class Redrawn {
 public:
  Redrawn(const ResponseMatrix& matrix, Experiment experiment, const std::string& study, std::uint64_t seed)
      : counts_(matrix),
        subjects_(matrix.subjects()),
        key_(make_stream_key(seed, name_stream(experiment, study))) {}

  // Resamples from `first` to before `end`, at most kLanes. shape: one for each cell
  std::vector<LaneCounts> count(int first, int end) const {
    std::vector<Lanes> weights(subjects_);
    const Below below(std::max<std::size_t>(subjects_, 1));
    for (int number = first; number < end; ++number) {
      RandomRun random(key_, static_cast<std::uint64_t>(number));
      const auto lane = static_cast<std::size_t>(number - first);
      for (std::size_t i = 0; i < subjects_; ++i) weights[below(random)].add(lane, 1);
    }
    return counts_.count(weights);
  }

 private:
  WeightedCounts counts_;
  std::size_t subjects_;
  StreamKey key_;
};

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

void add_resample(ResampleRun& run, const std::vector<ColumnSlots>& columns) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const ColumnCuts cuts = judge(columns[c]);
    ResampleSums& sums = run.columns[c];
    for (std::size_t r = 0; r < sums.shares.size(); ++r) {
      run.verdicts[r].push_back(judge_resample(cuts.artifact[r], cuts.material[r]));
      sums.shares[r].add(run.verdicts[r].back());
      sums.free[r].add(judge_free(cuts.artifact[r]));
      sums.artifact[r].add(cuts.artifact[r], Experiment::kArtifact);
      sums.material[r].add(cuts.material[r], Experiment::kMaterial);
    }
  }
}

// Those from `first` to `end`.
ResampleRun resample(std::vector<ColumnSlots> columns, const Redrawn& artifact, const Redrawn& material,
                     int first, int end) {
  ResampleRun run;
  for (const ColumnSlots& column : columns) {
    const std::vector<CutHistogram> empty(2, CutHistogram(column.levels));
    run.columns.push_back({{}, {}, empty, empty});
  }
  constexpr int kTogether = kLanes;
  for (int begin = first; begin < end; begin += kTogether) {
    const int beyond = std::min(end, begin + kTogether);
    const auto seen = artifact.count(begin, beyond), changed = material.count(begin, beyond);
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(beyond - begin); ++lane) {
      for (ColumnSlots& column : columns) {
        column.artifact.fill([&](std::size_t cell) { return seen[cell].of(lane); });
        column.material.fill([&](std::size_t cell) { return changed[cell].of(lane); });
      }
      add_resample(run, columns);
    }
  }
  return run;
}

// Does `work` on parts of 0 to before `items` side by side. shape: what each part gives, in order
template <typename Work>
auto split_work(int items, int threads, const Work& work) {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  const int parts = std::clamp(threads > 0 ? threads : cores, 1, std::max(items, 1));
  const auto begin_of = [&](int part) { return static_cast<int>(std::int64_t{items} * part / parts); };
  std::vector<std::future<decltype(work(0, 0))>> running;
  for (int part = 0; part < parts; ++part)
    running.push_back(std::async(std::launch::async, work, begin_of(part), begin_of(part + 1)));
  std::vector<decltype(work(0, 0))> results;
  for (auto& part : running) results.push_back(part.get());
  return results;
}

// Every resample has a stream of its own.
ResampleRun resample_all(const std::vector<ColumnSlots>& columns, const std::string& study,
                         const ResponseMatrix& artifact, const ResponseMatrix& material,
                         const UncertaintyParams& params) {
  const Redrawn seen(artifact, Experiment::kArtifact, study, params.seed),
      changed(material, Experiment::kMaterial, study, params.seed);
  const auto runs = split_work(params.resamples, params.threads, [&](int first, int end) {
    return resample(columns, seen, changed, first, end);
  });
  ResampleRun all = runs.front();
  for (std::size_t part = 1; part < runs.size(); ++part) all.append(runs[part]);
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

  // Empty where the person is not among the subjects, and leaves the counts as they are.
  std::vector<Count> without(const std::optional<std::size_t>& subject) const {
    return subject ? subtract_subject(all, matrix, *subject) : std::vector<Count>();
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
void compare_without(ColumnUncertainty& result, const ColumnCuts& without, const ColumnCuts& whole,
                     const Person& person, const ResponseMatrix& artifact, const ResponseMatrix& material) {
  for (std::size_t r = 0; r < result.by_rule.size(); ++r) {
    RuleUncertainty& under = result.by_rule[r];
    if (is_resampled(under.status)) {
      const auto exists = [&](const ColumnCuts& cuts) {
        return is_any_equivalent(cuts.artifact[r], cuts.material[r]);
      };
      if (exists(without) != exists(whole)) note_flip(under, person, artifact, material);
    } else if (is_unasked(under.status) && person.artifact) {
      const auto is_any_free = [&](const ColumnCuts& cuts) {
        return judge_free(cuts.artifact[r]) == Resampled::kExists;
      };
      if (is_any_free(without) != is_any_free(whole))
        under.free_flips.push_back(artifact.sessions[*person.artifact]);
    }
  }
}

void sort_flips(ColumnUncertainty& result) {
  for (RuleUncertainty& under : result.by_rule) {
    std::sort(under.artifact_flips.begin(), under.artifact_flips.end());
    std::sort(under.material_flips.begin(), under.material_flips.end());
    std::sort(under.free_flips.begin(), under.free_flips.end());
  }
}

// Leaves each person out in turn, from both experiments, for the columns from `first` to before `end`.
void find_flips(std::vector<ColumnUncertainty>& results, std::vector<ColumnSlots> columns,
                const ResponseMatrix& artifact, const ResponseMatrix& material, std::size_t first,
                std::size_t end) {
  const LeaveOut seen{artifact}, changed{material};
  std::vector<ColumnCuts> whole;
  for (const ColumnSlots& column : columns) whole.push_back(judge(column));
  for (const Person& person : pair_persons(artifact, material)) {
    const std::vector<Count> seen_without = seen.without(person.artifact),
                             changed_without = changed.without(person.material);
    for (std::size_t c = first; c < end; ++c) {
      ColumnCuts cuts = whole[c];
      if (person.artifact) {
        columns[c].artifact.fill([&](std::size_t cell) { return seen_without[cell]; });
        cuts.artifact = place_cuts(columns[c].artifact.counts, Experiment::kArtifact);
      }
      if (person.material) {
        columns[c].material.fill([&](std::size_t cell) { return changed_without[cell]; });
        cuts.material = place_cuts(columns[c].material.counts, Experiment::kMaterial);
      }
      compare_without(results[c], cuts, whole[c], person, artifact, material);
    }
  }
  for (std::size_t c = first; c < end; ++c) sort_flips(results[c]);
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
  }
  result.subjects = std::min(artifact.subjects(), material.subjects());
  ResampleRun run = resample_all(columns, study.name, artifact, material, params);
  if (artifact.subjects() > 1 && material.subjects() > 1) result.resamples = std::move(run.verdicts);
  for (std::size_t c = 0; c < columns.size(); ++c)
    take_sums(result.columns[c], run.columns[c], artifact.subjects(), material.subjects(), params.level);
  // Columns side by side: every cell has a stream of its own.
  split_work(static_cast<int>(columns.size()), params.threads, [&](int first, int end) {
    const auto begin = static_cast<std::size_t>(first), beyond = static_cast<std::size_t>(end);
    for (std::size_t c = begin; c < beyond; ++c)
      take_posteriors(result.columns[c], findings[c], columns[c], {params.seed, params.posterior_draws});
    find_flips(result.columns, columns, artifact, material, begin, beyond);
    return true;
  });
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
