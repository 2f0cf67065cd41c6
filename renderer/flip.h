// How different two displayed pictures look to somebody who flips between them.
#pragma once

#include <vector>

#include "stimuli/image.h"

namespace equilux {

/// The LDR-FLIP error of each pixel, 0 where nothing differs, up to 1. shape: height x width. Pictures are of
/// one size. `pixels_per_degree` of visual angle: what blurs together at that distance is not told apart.
/// Beyond the border the border's values go on. source: Andersson, Nilsson, Akenine-Moller, Oskarsson,
/// Astrom, Fairchild, "FLIP: a difference evaluator for alternating images", PACM CGIT 3(2), 2020.
std::vector<double> measure_flip(const LdrImage& reference, const LdrImage& test, double pixels_per_degree);

}  // namespace equilux
