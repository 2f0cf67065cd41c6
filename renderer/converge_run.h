// One picture of an object's indirect light by one method at one setting, timed stage by stage.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "renderer/light_tree.h"
#include "renderer/shade.h"
#include "renderer/vpl_sets.h"

namespace equilux {

enum class LightMethod {
  kPaths,      ///< path tracing
  kPlainSum,   ///< of all VPLs
  kLightcuts,  ///< as `image` renders them, without the measuring of their error
  kSets        ///< mean of independent VPL sets with fixed thresholds
};

/// What is done about what the clamp takes.
enum class ClampRemedy { kNone, kNormalised, kCompensated };

struct LightSetting {
  LightMethod method = LightMethod::kPaths;
  std::int64_t vpls = 0;
  double error_ratio = 0;
  int clamp_level = 0;
  ClampRemedy remedy = ClampRemedy::kNone;
  int paths_a_pixel = 0;  ///< path tracing's, or compensation's
  int sets = 0;
};

/// An object in a scene, ready to be lit.
struct LitScene {
  const World& world;
  const Materials& materials;
  const Primary& primary;
  const std::vector<ShadingPoint>& points;
  Emission emission = Emission::kLambertian;
  double floor = 0;  ///< of lightcuts, see LightcutParams
};

/// Seconds by stage.
struct StageTimes {
  std::map<std::string, double> wall_s, cpu_s;
};

struct LitLayer {
  HdrImage layer;  ///< premultiplied by coverage
  StageTimes times;
};

/// errors: InputError
LitLayer light_object(const LitScene& scene, const LightSetting& setting, std::uint64_t seed);

/// The set that light_object takes for a number and a seed. `times` may be null.
VplList trace_run_vpls(const LitScene& scene, std::int64_t vpls, std::uint64_t seed, StageTimes* times);

/// The tree over it. errors: InputError for lack of memory
LightTree make_run_tree(const LitScene& scene, std::int64_t vpls, std::uint64_t seed, StageTimes* times);

/// Rough time of a setting, by which longer ones are foreseen from shorter ones. units: paths
double estimate_work(const LitScene& scene, const LightSetting& setting);

}  // namespace equilux
