// What is foreseen to be done: in which order, at what cost, and in which shares.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "renderer/reference_params.h"
#include "renderer/wanted.h"
#include "renderer/world.h"

namespace equilux {

/// Costs in units of a path, measured on the café: a pair of point and VPL, a VPL with its share of the tree.
inline constexpr double kPairCost = 0.02, kVplCost = 0.57;

/// The same of the cuts of an object's points at all levels, and of the measuring of their error. Points of
/// small pictures lie further apart, so that less is shared.
double cost_of_cuts(std::int64_t vpls, double points);
double cost_of_measuring(std::int64_t vpls);

/// Of making a world, twice: a set looks at all before it renders; and of writing an EXR layer and making a
/// PNG picture of layers. units: paths; `...Pixel`, `...Triangle`: paths each
inline constexpr double kWorldCost = 6e5, kWorldTriangleCost = 1.2, kLayerCost = 4e3, kLayerPixelCost = 0.19,
                        kPictureCost = 3e3, kPicturePixelCost = 0.33;

/// Of a material's VPLs those that are its own: on the object, or after it.
inline constexpr double kOwnVpls = 0.3;

/// A geometry under an illumination: the objects that share a world.
struct WorldKey {
  std::string geometry;
  Illumination illumination = Illumination::kIndirect;
  auto operator<=>(const WorldKey&) const = default;
};

WorldKey world_of(const Object& object);

/// What an object that meets itself costs beside a ball, in plain sums and fixed paths, cuts, and references:
/// its rays pass more triangles, neighbours see less of the same, and light stays longer in its folds.
struct ShapeCosts {
  double sums = 1, cuts = 1, references = 1;
  double of_reference(const ReferenceParams& params) const;
};

/// Fitted to G0 to G3, Bunny and Dragon. units: share of rays, spread by cosine, that meet the object
ShapeCosts cost_of_shape(double self_occlusion);

/// Of one world, from a small picture of what the camera sees. units: paths
struct WorldCosts {
  double points = 0;  ///< of the object in a view, all subpixel positions; a number, no cost
  std::map<std::string, double> object;  ///< a reference's, by material
  double room = 0;                       ///< the backgrounds of a view
  double layer = 0;                      ///< the writing of a layer
  double world = 0;                      ///< its making
  ShapeCosts shape;
};

/// A reference of each material, to estimate costs by.
std::vector<Family> pick_references(const Study& study);

WorldCosts estimate_costs(const Study& study, const Scene& scene, const World& world,
                          const std::vector<Family>& references);

/// Of this machine: half a second of path tracing in the study's first world, of processors, so that it is
/// the speed without what else is running now. units: paths / s
double measure_speed(const Study& study, const Scene& scene);

/// An object in a view: the least that is rendered together, since cuts need the reference. `shared` is paid
/// once where several items have it: worlds, VPL sets and the backgrounds of a view. units: paths
struct WorkItem {
  Family family;
  bool has_reference = false;  ///< it is to be rendered, not only read
  std::vector<Condition> conditions;
  double own = 0;
  std::map<std::string, double> shared;
};

/// Of a noise target that asks for errors far below what 8 bits show; else empty.
std::string tell_narrow_target(const Study& study);

/// In the order of work: by world, view and material. shape of `costs`: every world of `wanted`. References
/// of conditions that `wanted.families` lacks are on disk.
std::vector<WorkItem> list_work(const std::map<WorldKey, WorldCosts>& costs, const Wanted& wanted);

/// Of tone mapping and writing the pictures, which no share does.
double cost_of_pictures(const Study& study, const Wanted& wanted);

/// What is shared counts once.
double sum_work(const std::vector<WorkItem>& items);

/// `count` runs of items, some empty where there are fewer, with the least longest one: the same on every
/// machine of one instruction set.
std::vector<std::vector<WorkItem>> split_work(const std::vector<WorkItem>& items, int count);

Wanted join_work(const std::vector<WorkItem>& items);

}  // namespace equilux
