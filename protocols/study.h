// A study: what is shown and how it is made, read from protocols/*.json and checked in full before anything
// runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "protocols/condition.h"

namespace equilux {

inline constexpr int kStudySchemaVersion = 1;
inline constexpr int kWindowLevels =
    4;  ///< adjacent clamp levels that the artifact experiment tests in each column

/// A full factorial part of a study. A study is the union of its blocks, which may not overlap.
struct Block {
  std::vector<std::string> geometries;
  std::vector<std::string> materials;
  std::vector<Illumination> illuminations;
  std::vector<std::int64_t> vpl_counts;
};

/// Fixed numbers of Monte Carlo paths for each pixel, shared out evenly over the subpixel positions.
struct PathCounts {
  int object_indirect = 0;
  int object_direct = 0;
  int background = 0;
};

/// Standard error wanted of a reference. units: display steps of 255.
struct NoiseTarget {
  double object_mean = 0;
  double object_p99 = 0;
  double outside_mean = 0;
  bool operator==(const NoiseTarget&) const = default;
};

enum class Exposure {
  kBackground,
  kWhole
};  ///< pixels that set a family's tone curve: of coverage 0, or all

/// Reinhard's operator: one curve for all pixels, or each by the luminance around it (dodging and burning).
enum class ToneOperator { kGlobal, kLocal };

/// How radiance becomes what a screen shows.
struct ToneMapping {
  ToneOperator operation = ToneOperator::kGlobal;
  double key = 0.18;
  Exposure exposure = Exposure::kBackground;
};

/// How the object's indirect light in a reference is made; both ways are unbiased. Compensated: the mean of
/// independent VPL sets and what their clamp takes, by paths, where that is foreseen to be faster.
enum class ReferenceMethod { kPath, kCompensated };

/// How a VPL sends its light on: by the diffuse part of the surface it lies on, as the paper's formula says,
/// or by all of its BRDF.
enum class Emission { kLambertian, kFull };

enum class ViewMode {
  kReferenceTurned,
  kPairTurned
};  ///< material trials: the upper picture, or one of the pair, is turned

struct Study {
  std::string name;
  std::string description;
  std::filesystem::path scene_path;    ///< absolute or relative to the working folder
  std::filesystem::path windows_path;  ///< the default windows.json beside the study file
  std::filesystem::path truth_path;    ///< the default planted truth beside the study file
  std::filesystem::path session_path;  ///< the default session.json beside the study file; empty: none
  std::uint64_t seed = 1;
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  int subpixel_positions = 1;
  std::optional<PathCounts>
      paths;  ///< of references; empty: as many as noise_target asks for, pixel by pixel
  NoiseTarget noise_target;
  ReferenceMethod reference = ReferenceMethod::kPath;
  Emission emission = Emission::kLambertian;
  ToneMapping tone;
  /// That by which paths of references and floors of cuts are planned, so that layers depend on it and not on
  /// `tone`: the same, unless a study maps the layers of another anew.
  ToneMapping planned_tone;
  std::vector<int> clamp_levels;
  bool certified = false;  ///< lightcuts are refined until 99 % of the points measured err by under 1 %
  bool normalise = false;  ///< every VPL picture is luminance-normalised (key C4n)
  ViewMode view_mode = ViewMode::kReferenceTurned;
  std::vector<std::string> reference_materials;  ///< artifact trials: where a geometry has no other material
  double target_degrees_wide = 16;
  double target_degrees_high = 12;
  double viewing_distance_m = 0.4572;   ///< 18 inches
  std::map<std::string, int> subjects;  ///< default number for "artifact" and "material"
  std::vector<Block> blocks;
  Json source;         ///< the file as read, with what it extends
  std::string digest;  ///< of the source
};

/// A study may say `"extends": "OTHER.json"`: then members that it has replace those of the other, and
/// `more_blocks` are added to its blocks. errors: InputError with file and JSON pointer, of blocks as counted
/// together.
Study load_study(const std::filesystem::path& path);

std::vector<Object> enumerate_objects(const Study& study);
std::vector<Column> enumerate_columns(const Study& study);
/// Cells in order of column, then clamp level.
std::vector<Cell> enumerate_cells(const Study& study);
/// VPL pictures of both views.
std::vector<Condition> enumerate_conditions(const Study& study);
/// References of the study's own objects, both views: the counts of study.md ("before reference_materials").
std::vector<Family> enumerate_families(const Study& study);
/// All references that must be rendered: the families, and those that reference_materials adds.
std::vector<Family> enumerate_references(const Study& study);

/// Materials from which an artifact trial of this object draws its reference: the study's other materials of
/// that geometry and illumination; where there are none, reference_materials without its own. Never empty for
/// a checked study.
std::vector<std::string> enumerate_reference_materials(const Study& study, const Object& object);

}  // namespace equilux
