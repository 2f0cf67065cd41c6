// Obvious pictures: for practice, attention and examples.
#include "experiment/extra_trials.h"

#include <algorithm>
#include <iterator>
#include <set>

#include "base/error.h"
#include "base/random.h"

namespace equilux {
namespace {

constexpr unsigned kComboCount = 4;

RandomStream make_stream(Experiment experiment, SubjectKind kind, const char* what, std::uint64_t seed,
                         std::int64_t index) {
  return {seed, fmt::format("schedule/{}/{}/{}", format_experiment(experiment), format_kind(kind), what),
          static_cast<std::uint64_t>(index)};
}

// Each cell once before any comes again, and each combination of view and side too.
std::vector<TrialRow> draw_obvious_trials(const Study& study, Experiment experiment, int count, Phase phase,
                                          RandomStream random) {
  std::vector<Cell> cells = enumerate_obvious_cells(study, experiment);
  std::vector<unsigned> combos;
  std::vector<TrialRow> trials;
  for (int i = 0; i < count; ++i) {
    const std::size_t number = static_cast<std::size_t>(i) % cells.size();
    if (number == 0) shuffle(cells, random);
    if (combos.empty()) {
      combos = {0, 1, 2, 3};
      static_assert(kComboCount == 4);
      shuffle(combos, random);
    }
    const Object& object = cells[number].column.object;
    const auto materials = enumerate_reference_materials(study, object);
    const std::string& material = materials[random.next_below(materials.size())];
    trials.push_back(make_trial(study, experiment, cells[number], combos.back(), material));
    trials.back().phase = phase;
    combos.pop_back();
  }
  return trials;
}

// One in each stretch, so that attention is tested all along.
std::vector<TrialRow> spread(std::vector<TrialRow> counted, std::vector<TrialRow> extra,
                             RandomStream random) {
  if (extra.empty()) return counted;
  std::vector<TrialRow> all;
  std::size_t next = 0;
  for (std::size_t i = 0; i < extra.size(); ++i) {
    const std::size_t end = counted.size() * (i + 1) / extra.size();
    const std::size_t place = next + random.next_below(end - next + 1);
    std::move(counted.begin() + static_cast<std::ptrdiff_t>(next),
              counted.begin() + static_cast<std::ptrdiff_t>(place), std::back_inserter(all));
    all.push_back(std::move(extra[i]));
    std::move(counted.begin() + static_cast<std::ptrdiff_t>(place),
              counted.begin() + static_cast<std::ptrdiff_t>(end), std::back_inserter(all));
    next = end;
  }
  return all;
}

std::int64_t find_fewest_vpls(const Study& study, const Object& object) {
  std::int64_t fewest = 0;
  for (const Column& column : enumerate_columns(study)) {
    if (column.object != object) continue;
    if (fewest == 0 || column.vpl_count < fewest) fewest = column.vpl_count;
  }
  return fewest;
}

void add_keys(const TrialRow& trial, std::set<std::string>& keys) {
  for (const std::string* key : {&trial.test_key, &trial.pair_key, &trial.upper_key}) {
    if (!key->empty()) keys.insert(*key);
  }
}

// What any subject's practice and catch trials may show.
void add_obvious_keys(const Study& study, Experiment experiment, std::set<std::string>& keys) {
  for (const Cell& cell : enumerate_obvious_cells(study, experiment)) {
    for (const std::string& material : enumerate_reference_materials(study, cell.column.object)) {
      for (unsigned combo = 0; combo < kComboCount; ++combo)
        add_keys(make_trial(study, experiment, cell, combo, material), keys);
    }
  }
}

}  // namespace

std::vector<Cell> enumerate_obvious_cells(const Study& study, Experiment experiment) {
  const int level =
      experiment == Experiment::kArtifact ? study.clamp_levels.front() : study.clamp_levels.back();
  std::vector<Cell> cells;
  for (const Object& object : enumerate_objects(study))
    cells.push_back({{object, find_fewest_vpls(study, object)}, level, study.normalise});
  return cells;
}

std::vector<TrialRow> add_extra_trials(std::vector<TrialRow> counted, const Study& study,
                                       const SessionProtocol& protocol, Experiment experiment,
                                       SubjectKind kind, std::uint64_t session_seed, std::int64_t index) {
  const auto draw = [&](const char* what, int count, Phase phase) {
    return draw_obvious_trials(study, experiment, count, phase,
                               make_stream(experiment, kind, what, session_seed, index));
  };
  std::vector<TrialRow> all = draw("practice", protocol.practice_trials, Phase::kPractice);
  const int catches = protocol.catch_trials ? protocol.catch_trials->count : 0;
  std::vector<TrialRow> rest = spread(std::move(counted), draw("catch", catches, Phase::kCatch),
                                      make_stream(experiment, kind, "catch-places", session_seed, index));
  std::move(rest.begin(), rest.end(), std::back_inserter(all));
  for (std::size_t i = 0; i < all.size(); ++i) all[i].number = static_cast<int>(i);
  return all;
}

std::vector<FamiliarPage> enumerate_familiar_pages(const Study& study, const SessionProtocol& protocol,
                                                   Experiment experiment) {
  std::vector<FamiliarPage> pages;
  if (protocol.shows_objects) {
    for (const Object& object : enumerate_objects(study))
      pages.push_back({format_key(Family{object, 0}), ""});
  }
  const std::vector<Cell> cells = enumerate_obvious_cells(study, experiment);
  const auto count = std::min(cells.size(), static_cast<std::size_t>(protocol.examples));
  for (std::size_t i = 0; i < count; ++i) {
    const Cell& cell = cells[i * cells.size() / count];  // evenly over the objects
    pages.push_back({format_key(Family{cell.column.object, 0}), format_key(Condition{cell, 0})});
  }
  return pages;
}

std::vector<std::string> enumerate_extra_keys(const Study& study, const SessionProtocol& protocol,
                                              Experiment experiment) {
  std::set<std::string> keys;
  if (protocol.practice_trials > 0 || protocol.catch_trials) add_obvious_keys(study, experiment, keys);
  for (const FamiliarPage& page : enumerate_familiar_pages(study, protocol, experiment)) {
    keys.insert(page.left_key);
    if (!page.right_key.empty()) keys.insert(page.right_key);
  }
  return {keys.begin(), keys.end()};
}

}  // namespace equilux
