// One picture of a scene, outside any study.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "protocols/study.h"
#include "renderer/tone.h"

namespace equilux {

struct PictureParams {
  std::filesystem::path scene_path;
  Object object;
  int view = 0;
  int width = 560;
  int height = 420;
  int positions = 4;
  PathCounts paths{256, 16, 256};
  std::optional<NoiseTarget> noise_target;  ///< as many paths as it asks for, in place of `paths`
  Emission emission = Emission::kLambertian;
  std::optional<std::int64_t> vpl_count;  ///< empty: path traced
  double clamp_per_m2 = 0;                ///< with VPLs; infinite for none
  std::uint64_t seed = 1;
};

struct Picture {
  HdrImage image;
  LdrImage display;            ///< through the tone curve of its own background
  std::int64_t vpl_count = 0;  ///< true number
  DisplayNoise noise;          ///< of its path-traced parts
  LdrImage noise_display;  ///< the same at each pixel, 51 grey levels a step: white is five steps and more
  double paths = 0;        ///< traced for those, in all
};

/// errors: InputError
Picture make_picture(const PictureParams& params);

}  // namespace equilux
