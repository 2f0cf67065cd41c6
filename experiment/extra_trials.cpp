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
std::vector<TrialRow> draw_obvious_trials(const Study& study, Experiment experiment, std::vector<Cell> cells,
                                          int count, Phase phase, RandomStream random) {
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

// Of an object, the most obvious first.
std::vector<Cell> order_by_obviousness(const Study& study, Experiment experiment, const Object& object) {
  std::set<std::int64_t> counts;
  for (const Column& column : enumerate_columns(study)) {
    if (column.object == object) counts.insert(column.vpl_count);
  }
  std::vector<int> levels = study.clamp_levels;
  if (experiment == Experiment::kMaterial) std::reverse(levels.begin(), levels.end());
  std::vector<Cell> cells;
  for (const int level : levels) {
    for (const std::int64_t count : counts) cells.push_back({{object, count}, level, study.normalise});
  }
  return cells;
}

void add_keys(const TrialRow& trial, std::set<std::string>& keys) {
  for (const std::string* key : {&trial.test_key, &trial.pair_key, &trial.upper_key}) {
    if (!key->empty()) keys.insert(*key);
  }
}

// What any subject's practice and catch trials may show.
void add_obvious_keys(const Study& study, Experiment experiment, const std::vector<Cell>& cells,
                      std::set<std::string>& keys) {
  for (const Cell& cell : cells) {
    for (const std::string& material : enumerate_reference_materials(study, cell.column.object)) {
      for (unsigned combo = 0; combo < kComboCount; ++combo)
        add_keys(make_trial(study, experiment, cell, combo, material), keys);
    }
  }
}

}  // namespace

std::vector<Cell> enumerate_obvious_cells(const Study& study, Experiment experiment,
                                          const std::vector<Cell>& counted) {
  const std::set<Cell> taken(counted.begin(), counted.end());
  std::vector<Cell> cells;
  for (const Object& object : enumerate_objects(study)) {
    const std::vector<Cell> own = order_by_obviousness(study, experiment, object);
    const auto free =
        std::find_if(own.begin(), own.end(), [&](const Cell& cell) { return !taken.contains(cell); });
    cells.push_back(free == own.end() ? own.front() : *free);
  }
  return cells;
}

std::vector<TrialRow> add_extra_trials(std::vector<TrialRow> counted, const Study& study,
                                       const SessionProtocol& protocol, Experiment experiment,
                                       SubjectKind kind, std::uint64_t session_seed, std::int64_t index) {
  std::vector<Cell> cells;
  for (const TrialRow& trial : counted) cells.push_back(trial.cell);
  const std::vector<Cell> obvious = enumerate_obvious_cells(study, experiment, cells);
  const auto draw = [&](const char* what, int count, Phase phase) {
    return draw_obvious_trials(study, experiment, obvious, count, phase,
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
                                                   Experiment experiment, const std::vector<Cell>& counted) {
  std::vector<FamiliarPage> pages;
  if (protocol.shows_objects) {
    for (const Object& object : enumerate_objects(study))
      pages.push_back({format_key(Family{object, 0}), ""});
  }
  const std::vector<Cell> cells = enumerate_obvious_cells(study, experiment, counted);
  const auto count = std::min(cells.size(), static_cast<std::size_t>(protocol.examples));
  for (std::size_t i = 0; i < count; ++i) {
    const Cell& cell = cells[i * cells.size() / count];  // evenly over the objects
    pages.push_back({format_key(Family{cell.column.object, 0}), format_key(Condition{cell, 0})});
  }
  return pages;
}

std::vector<std::string> enumerate_extra_keys(const Study& study, const SessionProtocol& protocol,
                                              Experiment experiment, const std::vector<Cell>& counted) {
  std::set<std::string> keys;
  if (protocol.practice_trials > 0 || protocol.catch_trials)
    add_obvious_keys(study, experiment, enumerate_obvious_cells(study, experiment, counted), keys);
  for (const FamiliarPage& page : enumerate_familiar_pages(study, protocol, experiment, counted)) {
    keys.insert(page.left_key);
    if (!page.right_key.empty()) keys.insert(page.right_key);
  }
  return {keys.begin(), keys.end()};
}

}  // namespace equilux
