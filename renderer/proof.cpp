// Two estimators at the same points.
#include "renderer/proof.h"

#include <cmath>

#include "base/error.h"
#include "renderer/family.h"
#include "renderer/parallel.h"
#include "renderer/shade.h"

namespace equilux {
namespace {

constexpr int kWidth = 128, kHeight = 96;

// Even in their order along the Morton curve over pixels.
std::vector<ShadingPoint> pick_points(const Scene& scene, const World& world, const ProofParams& params) {
  const auto all =
      find_shading_points(trace_primary(world, make_view_camera(scene, params.view), kWidth, kHeight, 1));
  float top = scene.stand.z;
  for (const ShadingPoint& point : all) top = std::max(top, point.surface.p.z);
  const double least = scene.stand.z + params.contact_band * (top - scene.stand.z);
  std::vector<ShadingPoint> outside;
  for (const ShadingPoint& point : all) {
    if (point.surface.p.z >= least) outside.push_back(point);
  }
  if (outside.empty())
    throw InputError(scene.path.string(), "/object", "an object that the camera sees", "none");
  std::vector<ShadingPoint> picked;
  for (int i = 0; i < kProofPoints; ++i) {
    // Points of a group are far apart: their errors then have little in common.
    const int group = i / 16, place = i % 16 * kProofGroups + group;
    const auto share = (place + 0.5) / kProofPoints;
    picked.push_back(outside[static_cast<std::size_t>(share * static_cast<double>(outside.size()))]);
  }
  return picked;
}

struct ProofScene {
  const World& world;
  const Materials& materials;
  const std::vector<ShadingPoint>& points;
};

double mean_luminance(const std::vector<Vec3>& radiance) {
  double sum = 0;
  for (Vec3 value : radiance) sum += luminance(value);
  return sum / static_cast<double>(radiance.size());
}

double shade_mean(const ProofScene& scene, const VplList& vpls, const std::vector<ShadingPoint>& points) {
  return mean_luminance(shade_all_vpls(scene.world, points, vpls, {scene.materials[kObjectMaterial]},
                                       {clamp_per_m2(0)}, [](double) {})
                            .radiance);
}

double shade_set(const ProofScene& scene, const VplSet& set, std::size_t group) {
  const auto first = scene.points.begin() + static_cast<std::ptrdiff_t>(16 * group);
  return shade_mean(scene, set.shared, {first, first + 16}) + shade_mean(scene, set.own, scene.points);
}

VplSet without_gloss(VplSet set) {
  for (VplList* list : {&set.shared, &set.own}) {
    for (Vpl& vpl : list->vpls) vpl.gloss = -1;
  }
  return set;
}

// Mean over the points by one randomisation of the paths.
double trace_batch(const ProofScene& scene, const ProofParams& params, std::uint64_t batch) {
  const StreamKey key = make_stream_key(params.seed, "proof.paths");
  const int paths = std::max(1, params.camera_paths / kBatches);
  double sum = 0;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    const ShadingPoint& point = scene.points[i];
    PathSampler sampler(RandomStream(key, i * kBatches + batch));
    for (int path = 0; path < paths; ++path) {
      sampler.next_path();
      sum +=
          luminance(estimate_reflected(scene.world, scene.materials, point.surface, point.v, false, sampler));
    }
  }
  return sum / (static_cast<double>(scene.points.size()) * paths);
}

// Strata of equal size, `count` values each, one after the other: the mean, and its error from the spread
// within the strata.
ProofEstimate summarise(const std::vector<double>& values, std::size_t count) {
  const std::size_t strata = values.size() / count;
  const auto n = static_cast<double>(count);
  double total = 0, variance = 0;
  for (std::size_t stratum = 0; stratum < strata; ++stratum) {
    double sum = 0, squares = 0;
    for (std::size_t i = 0; i < count; ++i) sum += values[stratum * count + i];
    for (std::size_t i = 0; i < count; ++i) squares += std::pow(values[stratum * count + i] - sum / n, 2);
    total += sum / n;
    variance += squares / (n - 1) / n;
  }
  const auto m = static_cast<double>(strata);
  return {total / m, std::sqrt(variance) / m};
}

}  // namespace

ProofEstimate find_relative_difference(const ProofEstimate& vpls, const ProofEstimate& paths) {
  return {vpls.mean / paths.mean - 1, std::hypot(vpls.standard_error, paths.standard_error) / paths.mean};
}

Proof make_proof(const Scene& scene, const MaterialSpec& material, const ProofParams& params) {
  const World world = make_world(scene, params.object.geometry, params.object.illumination);
  const Materials materials = make_materials(world, material);
  const auto points = pick_points(scene, world, params);
  const ProofScene proof{world, materials, points};
  const auto repeats = static_cast<std::size_t>(params.repeats);
  std::vector<double> paths(kBatches), full(kProofGroups * repeats), lambertian(full.size());
  for_each_parallel(paths.size(), [&](std::size_t i) { paths[i] = trace_batch(proof, params, i); });
  for_each_parallel(full.size(), [&](std::size_t i) {
    const VplSet set =
        trace_vpls(world, materials, params.vpl_paths, params.seed + i, "proof.vpls", Emission::kFull);
    full[i] = shade_set(proof, set, i / repeats);
    if (params.with_lambertian) lambertian[i] = shade_set(proof, without_gloss(set), i / repeats);
  });
  return {summarise(paths, kBatches), summarise(full, repeats), summarise(lambertian, repeats)};
}

}  // namespace equilux
