// Two renderers' pictures of one scene, each with several seeds: do they agree, and which is less noisy?
#pragma once

#include <array>
#include <string>
#include <vector>

#include "stimuli/image.h"
#include "tests/support/statistics.h"

namespace equilux::test {

/// A part of the picture. shape of weights: height x width; they sum to 1.
struct Region {
  std::string name;
  std::vector<double> weights;
};

/// A grid of cells, then all of the picture, then the object: each pixel by its coverage.
std::vector<Region> make_regions(const HdrImage& coverage, int columns, int rows);

/// Two renderers agree if their means are this close, as a share: fixed subpixel positions against random
/// ones, and what float's rounding loses along edges, come to a few parts in ten thousand.
inline constexpr double kMargin = 0.001;

/// Mean radiance of a region in one channel, of both renderers, and Welch's test of whether they differ by
/// more than the margin.
struct Agreement {
  std::string region;
  std::size_t channel = 0;
  Mean ours, theirs;
  double t = 0;        ///< of the difference itself, without the margin
  double degrees = 0;  ///< of freedom, after Satterthwaite
  double p = 1;        ///< two-sided, of the difference beyond the margin

  double relative_difference() const { return theirs.mean / ours.mean - 1; }
  /// The bias that a test at `level` finds in 95 of 100 runs, as a share of the mean.
  double visible_bias(double level) const;
};

/// Every picture of a renderer has another seed; all are of one size.
using Pictures = std::vector<HdrImage>;

/// Row by row: regions, in each the three channels.
std::vector<Agreement> compare_regions(const Pictures& ours, const Pictures& theirs,
                                       const std::vector<Region>& regions);

/// Root of the mean over pixels of (standard deviation over seeds / mean)^2, of luminance: the relative error
/// of one picture. The mean is that of all pictures of both renderers.
double measure_pixel_error(const Pictures& pictures, const Pictures& others);

}  // namespace equilux::test
