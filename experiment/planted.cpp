// Lapses, guesses and response times, each from its own stream.
#include "experiment/planted.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/random.h"

namespace equilux {
namespace {

RandomStream make_stream(const PlantedSubject& subject, const char* what, int trial) {
  const std::string name = fmt::format("planted/{}/{}", format_experiment(subject.experiment), what);
  return {subject.seed, name,
          (static_cast<std::uint64_t>(subject.index) << 32) | static_cast<unsigned>(trial)};
}

}  // namespace

bool is_visible(const Truth& truth, Experiment experiment, const Cell& cell) {
  const PlantedColumn& column = truth.by_column.at(cell.column);
  return experiment == Experiment::kArtifact ? cell.clamp_level < column.artifact_free_from
                                             : cell.clamp_level > column.material_same_to;
}

Side choose_planted_side(const Truth& truth, const PlantedSubject& subject, const TrialRow& trial) {
  const bool lapse = make_stream(subject, "lapse", trial.number).next_double() < truth.lapse_rate;
  if (!lapse && is_visible(truth, subject.experiment, trial.cell)) return trial.test_side;
  const bool left = make_stream(subject, "guess", trial.number).next_double() < truth.side_bias;
  return left ? Side::kLeft : Side::kRight;
}

std::int64_t draw_planted_response_time_ns(const PlantedSubject& subject, int trial) {
  RandomStream random = make_stream(subject, "response_time", trial);
  const double radius = std::sqrt(-2 * std::log(1 - random.next_double()));
  const double normal = radius * std::cos(2 * std::numbers::pi * random.next_double());
  const double seconds = std::clamp(1.5 * std::exp(std::log(1.5) * normal), 0.2, 30.0);
  return static_cast<std::int64_t>(seconds * 1e9);
}

std::string name_planted(std::uint64_t seed, std::int64_t index) {
  return fmt::format("planted-{}-{}", seed, index);
}

std::string name_next_planted(const TrialLog& log, std::uint64_t seed, std::int64_t index) {
  const std::string first = name_planted(seed, index);
  std::string name = first;
  for (int next = 2; log.has_withdrawn(name); ++next) name = fmt::format("{}-{}", first, next);
  return name;
}

}  // namespace equilux
