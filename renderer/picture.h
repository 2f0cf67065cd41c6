// One picture of a scene, outside any study; each object with settings of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "renderer/cut_error.h"
#include "renderer/tone.h"
#include "stimuli/scene.h"

namespace equilux {

struct PictureParams {
  std::filesystem::path scene_path;
  /// Of the object. Where the scene has sculptures, no geometry means that every one is an object, with its
  /// own material.
  std::optional<std::string> geometry;
  std::optional<std::string> material;  ///< a sculpture's own if empty
  Illumination illumination = Illumination::kIndirect;
  int view = 0;
  std::optional<Camera> camera;  ///< in place of the view's
  int width = 560;
  int height = 420;
  int positions = 4;
  PathCounts paths{256, 16, 256};
  std::optional<NoiseTarget> noise_target;  ///< as many paths as it asks for, in place of `paths`
  Emission emission = Emission::kLambertian;
  std::optional<std::int64_t> vpl_count;           ///< empty: path traced
  double clamp_per_m2 = 0;                         ///< with VPLs; infinite for none
  std::map<std::string, double> clamps_by_object;  ///< in place of it for the objects named
  bool certified = false;  ///< cuts are refined until 99 % of the points measured err by under 1 %
  bool normalise = false;  ///< each object's clamped layer to the mean luminance of its unclamped one
  /// With VPLs: the mean of so many independent sets or more, see count_vpl_sets, by cuts
  /// whose thresholds are fixed beforehand: unbiased, with an error of its own. Empty: one set, whose cuts
  /// are measured.
  std::optional<int> sets;
  bool compensate = false;  ///< adds, by as many paths as indirect light has, what each object's clamp takes
  ToneMapping tone;
  std::uint64_t seed = 1;
};

/// Layers of one object, premultiplied by its coverage. Those of all objects and the background add up.
struct ObjectLayers {
  std::string name;
  double clamp_per_m2 = 0;  ///< with VPLs
  HdrImage coverage, direct, indirect;
  std::optional<HdrImage> compensation;  ///< of its VPLs' light; `indirect` holds it
  std::optional<CutMeasures> measures;   ///< of its VPLs' light, where that is by cuts; level 0 is the clamp
};

struct Picture {
  HdrImage image;
  HdrImage background;  ///< what is seen of the room
  std::vector<ObjectLayers> objects;
  LdrImage display;            ///< through the tone curve of its own background
  std::int64_t vpl_count = 0;  ///< true number, of several sets the mean
  int sets = 0;                ///< of VPLs, where there are several
  DisplayNoise noise;          ///< of its path-traced parts, and of VPL sets where there are several
  LdrImage noise_display;  ///< the same at each pixel, 51 grey levels a step: white is five steps and more
  double paths = 0;        ///< traced for those, in all
};

/// errors: InputError, also for a clamp of an object that the scene lacks
Picture make_picture(const PictureParams& params);

}  // namespace equilux
