// From cells to trials: sides, views and references balanced over subjects, the order drawn by session.
#include "experiment/schedule.h"

#include <algorithm>
#include <array>
#include <map>
#include <string_view>

#include "base/error.h"
#include "base/random.h"

namespace equilux {
namespace {

// A view and a side as two bits, so that "the other side and the other view" is an exclusive or with 3.
constexpr unsigned kComboCount = 4;
constexpr unsigned kBothTurned = 3;
// Ranks take the combos in this order: two left over are each other's opposite, and both margins stay even.
constexpr std::array<unsigned, kComboCount> kComboOfRank = {0, 3, 1, 2};

Side side_of(unsigned combo) { return (combo & 1) == 0 ? Side::kLeft : Side::kRight; }
int view_of(unsigned combo) { return static_cast<int>(combo >> 1); }

std::string stream_name(Experiment experiment, SubjectKind kind, std::string_view what) {
  return fmt::format("schedule/{}/{}/{}", format_experiment(experiment), format_kind(kind), what);
}

// What the streams of one schedule are drawn from. Those that balance subjects against each other start from
// the study's seed, which they share.
struct Draw {
  const Study& study;
  Experiment experiment;
  SubjectKind kind;
  std::uint64_t index;

  RandomStream shared(std::string_view what, std::uint64_t number) const {
    return {study.seed, stream_name(experiment, kind, what), number};
  }
};

// A subject's turn within its block of four: opposites follow each other, all four come once.
unsigned draw_turn(const Draw& draw) {
  RandomStream random = draw.shared("turn", draw.index / kComboCount);
  const auto first = static_cast<unsigned>(random.next_below(kComboCount));
  const unsigned third = first ^ static_cast<unsigned>(1 + random.next_below(2));
  const std::array<unsigned, kComboCount> turns = {first, first ^ kBothTurned, third, third ^ kBothTurned};
  return turns[draw.index % kComboCount];
}

// Each cell's place in its block of four subjects: every combo equally often, give or take one.
std::vector<unsigned> draw_offsets(const Draw& draw, std::size_t cell_count) {
  std::vector<unsigned> offsets;
  for (std::size_t rank = 0; rank < cell_count; ++rank) offsets.push_back(kComboOfRank[rank % kComboCount]);
  RandomStream random = draw.shared("offset", draw.index / kComboCount);
  shuffle(offsets, random);
  return offsets;
}

using MaterialsByObject = std::map<Object, std::vector<std::string>>;

MaterialsByObject find_reference_materials(const Study& study, const std::vector<Cell>& cells) {
  MaterialsByObject materials;
  for (const Cell& cell : cells) {
    const Object& object = cell.column.object;
    if (!materials.contains(object)) materials[object] = enumerate_reference_materials(study, object);
    EQ_CHECK(!materials[object].empty(), format_key(object));
  }
  return materials;
}

// Materials in blocks of as many subjects as there are materials; a fresh order for each cell and block.
std::string draw_reference_material(const Draw& draw, std::vector<std::string> materials,
                                    std::size_t cell_number) {
  RandomStream random =
      draw.shared("material", (std::uint64_t{cell_number} << 32) | (draw.index / materials.size()));
  shuffle(materials, random);
  return materials[draw.index % materials.size()];
}

TrialRow make_artifact_trial(const Cell& cell, unsigned combo, const std::string& material) {
  const Object& object = cell.column.object;
  const int view = view_of(combo);
  TrialRow trial;
  trial.cell = cell;
  trial.test_key = format_key(Condition{cell, view});
  trial.pair_key = format_key(Family{{object.geometry, material, object.illumination}, 1 - view});
  trial.test_side = side_of(combo);
  return trial;
}

TrialRow make_material_trial(const Cell& cell, unsigned combo, ViewMode mode) {
  const Object& object = cell.column.object;
  const int view = view_of(combo);
  const bool pair_turned = mode == ViewMode::kPairTurned;
  TrialRow trial;
  trial.cell = cell;
  trial.test_key = format_key(Condition{cell, view});
  trial.pair_key = format_key(Family{object, pair_turned ? 1 - view : view});
  trial.upper_key = format_key(Family{object, pair_turned ? view : 1 - view});
  trial.test_side = side_of(combo);
  return trial;
}

std::vector<std::string> sorted_without_repetition(std::vector<std::string> keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

}  // namespace

std::vector<Cell> enumerate_artifact_cells(const Study& study, const Windows& windows) {
  std::vector<Cell> cells;
  for (const Column& column : enumerate_columns(study)) {
    const int first = windows.by_column.at(column).first_level;
    for (int level = first; level < first + kWindowLevels; ++level) {
      cells.push_back({column, level, study.normalise});
    }
  }
  return cells;
}

TrialRow make_trial(const Study& study, Experiment experiment, const Cell& cell, unsigned combo,
                    const std::string& material) {
  if (experiment == Experiment::kArtifact) return make_artifact_trial(cell, combo, material);
  return make_material_trial(cell, combo, study.view_mode);
}

std::vector<TrialRow> make_schedule(const Study& study, Experiment experiment, const std::vector<Cell>& cells,
                                    SubjectKind kind, std::uint64_t session_seed, std::int64_t index) {
  EQ_CHECK(index >= 0, index);
  const Draw draw{study, experiment, kind, static_cast<std::uint64_t>(index)};
  const unsigned turn = draw_turn(draw);
  const std::vector<unsigned> offsets = draw_offsets(draw, cells.size());
  const MaterialsByObject materials = find_reference_materials(study, cells);
  std::vector<TrialRow> trials;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    const unsigned combo = offsets[i] ^ turn;
    const std::string material = experiment == Experiment::kArtifact
                                     ? draw_reference_material(draw, materials.at(cell.column.object), i)
                                     : "";
    trials.push_back(make_trial(study, experiment, cell, combo, material));
  }
  RandomStream order(session_seed, stream_name(experiment, kind, "order"), draw.index);
  shuffle(trials, order);
  for (std::size_t i = 0; i < trials.size(); ++i) trials[i].number = static_cast<int>(i);
  return trials;
}

std::vector<std::string> enumerate_shown(const std::vector<TrialRow>& trials) {
  std::vector<std::string> keys;
  for (const TrialRow& trial : trials) {
    keys.push_back(trial.test_key);
    keys.push_back(trial.pair_key);
    if (!trial.upper_key.empty()) keys.push_back(trial.upper_key);
  }
  return sorted_without_repetition(std::move(keys));
}

std::vector<std::string> enumerate_showable(const Study& study, Experiment experiment,
                                            const std::vector<Cell>& cells) {
  const MaterialsByObject materials = find_reference_materials(study, cells);
  std::vector<std::string> keys;
  for (const Cell& cell : cells) {
    const Object& object = cell.column.object;
    const std::vector<std::string> own = {object.material};
    const auto& shown = experiment == Experiment::kArtifact ? materials.at(object) : own;
    for (int view = 0; view < kViewCount; ++view) {
      keys.push_back(format_key(Condition{cell, view}));
      for (const std::string& material : shown) {
        keys.push_back(format_key(Family{{object.geometry, material, object.illumination}, view}));
      }
    }
  }
  return sorted_without_repetition(std::move(keys));
}

}  // namespace equilux
