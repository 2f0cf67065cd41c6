// Error against run time: ladders of settings of every method, held to one reference.
#pragma once

#include <string>
#include <vector>

#include "protocols/study.h"
#include "stimuli/convergence.h"
#include "stimuli/scene.h"

namespace equilux {

/// What the ladders are made of. Counts and levels rise.
struct ConvergeLadders {
  std::vector<std::int64_t> plain_counts{100, 300, 1000, 3000, 10000, 30000};
  std::vector<std::int64_t> cut_counts{1000, 10000, 100000, 1000000, 5000000};
  std::vector<double> error_ratios{0.06, 0.03, 0.015, 0.0075, 0.00375, 0.001875};
  std::vector<int> clamp_levels{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  int steps = 8;  ///< of path tracing, each with four times the paths; of remedies three
};

struct ConvergeParams {
  std::string source;   ///< name of the scene or study
  Condition condition;  ///< count and clamp level are those of the ladders that hold them fixed
  int width = 0, height = 0, positions = 1;
  Emission emission = Emission::kLambertian;
  ToneMapping tone;
  double pixels_per_degree = 35;
  std::uint64_t seed = 1;
  int seeds = 4;               ///< of each setting, at least 2
  int reference_paths = 8192;  ///< a pixel, of the object's indirect light
  double budget_s = 60;  ///< settings foreseen to take longer are left out, but for the first of each curve
  std::vector<double> asked_s{1, 10, 60};  ///< for which advice is wanted
  ConvergeLadders ladders;
};

/// Wall times are those of this machine with all threads of this process. The reference is path traced from
/// numbers of its own. The light that all methods share, direct light and background, is its own in every
/// picture and costs no time. errors: InputError
Convergence measure_convergence(const Scene& scene, const ConvergeParams& params);

}  // namespace equilux
