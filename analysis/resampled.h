// How a column is judged when its counts are drawn: by posterior draws and by resamples of subjects alike.
#pragma once

#include <cstdint>
#include <optional>

#include "analysis/placed_cut.h"

namespace equilux {

/// EE of a column in a draw or a resample.
enum class Resampled : std::uint8_t {
  kNone,  ///< also where no level is free of artifacts, whatever the material answers
  kExists,
  kUntested  ///< a level may be free of artifacts, and nobody was asked about the material
};

/// True iff some level is free of artifacts and of the same material.
bool is_any_equivalent(const PlacedCut& artifact, const PlacedCut& material);

/// Whether some level is free of artifacts.
Resampled judge_free(const PlacedCut& artifact);

/// Whether some level is equivalent.
Resampled judge_resample(const PlacedCut& artifact, const PlacedCut& material);

/// Share of verdicts that are kExists, of those that are not kUntested.
class Share {
 public:
  void add(Resampled verdict) {
    all_ += verdict != Resampled::kUntested ? 1 : 0;
    true_ += verdict == Resampled::kExists ? 1 : 0;
  }
  void add(const Share& other) {
    all_ += other.all_;
    true_ += other.true_;
  }
  std::optional<double> get() const {
    if (all_ == 0) return std::nullopt;
    return static_cast<double>(true_) / static_cast<double>(all_);
  }

 private:
  std::int64_t true_ = 0;
  std::int64_t all_ = 0;
};

}  // namespace equilux
