// Two estimators at the same points.
#include "renderer/proof.h"

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "renderer/family.h"
#include "renderer/parallel.h"
#include "renderer/shade.h"

namespace equilux {
namespace {

constexpr int kWidth = 256, kHeight = 192;

// Shadow rays are certain for a pair that gives this share of the mean light, rarer for the rest.
constexpr double kRouletteShare = .015;

// The spread of what an object reflects into itself grows with this, rho_s / alpha; as it is for MS.
constexpr float kPeakOfAllSets = 4.4f;
constexpr int kFewestOwnSets = 32;

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
  if (outside.size() <= kProofPoints) return outside;
  std::vector<ShadingPoint> picked;
  for (std::size_t i = 0; i < kProofPoints; ++i) picked.push_back(outside[i * outside.size() / kProofPoints]);
  return picked;
}

template <typename T>
std::vector<T> take_every(const std::vector<T>& points, std::size_t stride, std::size_t first) {
  std::vector<T> taken;
  for (std::size_t i = first; i < points.size(); i += stride) taken.push_back(points[i]);
  return taken;
}

double mean_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

ProofEstimate summarise(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  const double mean = mean_of(values);
  double squares = 0;
  for (double value : values) squares += std::pow(value - mean, 2);
  return {mean, std::sqrt(squares / (n - 1) / n)};
}

ProofEstimate add_independent(const ProofEstimate& a, const ProofEstimate& b) {
  return {a.mean + b.mean, std::hypot(a.standard_error, b.standard_error)};
}

struct ProofScene {
  const World& world;
  const std::vector<Materials>& materials;  ///< of the whole scene, for each material of the object
  const std::vector<ShadingPoint>& points;
};

// Luminance at each point by one randomisation of the paths.
std::vector<double> trace_batch(const ProofScene& scene, const Materials& materials,
                                const ProofParams& params, std::uint64_t batch) {
  const StreamKey key = make_stream_key(params.seed, "proof.paths");
  const int paths = std::max(1, params.camera_paths / kBatches);
  std::vector<double> means;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    const ShadingPoint& point = scene.points[i];
    PathSampler sampler(RandomStream(key, i * kBatches + batch));
    double sum = 0;
    for (int path = 0; path < paths; ++path) {
      sampler.next_path();
      sum += luminance(estimate_reflected(scene.world, materials, point.surface, point.v, false, sampler));
    }
    means.push_back(sum / paths);
  }
  return means;
}

struct PathTraced {
  ProofEstimate mean;
  std::vector<double> points;

  // A part of the points is brighter or darker than all.
  double excess_of(std::size_t stride, std::size_t first) const {
    return mean_of(take_every(points, stride, first)) - mean.mean;
  }
};

PathTraced trace_points(const ProofScene& scene, const Materials& materials, const ProofParams& params) {
  std::vector<std::vector<double>> batches(kBatches);
  for_each_parallel(batches.size(),
                    [&](std::size_t i) { batches[i] = trace_batch(scene, materials, params, i); });
  PathTraced traced{{}, std::vector<double>(scene.points.size())};
  std::vector<double> means;
  for (const auto& batch : batches) {
    means.push_back(mean_of(batch));
    for (std::size_t i = 0; i < batch.size(); ++i) traced.points[i] += batch[i] / kBatches;
  }
  traced.mean = summarise(means);
  return traced;
}

// Mean luminance by each material, material by material.
std::vector<double> shade_means(const ProofScene& scene, const std::vector<std::size_t>& which,
                                const VplList& vpls, const std::vector<ShadingPoint>& points,
                                const ShadowRoulette& roulette) {
  std::vector<Material> materials;
  for (std::size_t i : which) materials.push_back(scene.materials[i][kObjectMaterial]);
  const auto shaded = shade_all_vpls(
      scene.world, points, vpls, materials, {clamp_per_m2(0)}, [](double) {}, roulette);
  std::vector<double> means;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) sum += luminance(shaded.radiance[shaded.index(m, 0, i)]);
    means.push_back(sum / static_cast<double>(points.size()));
  }
  return means;
}

VplList without_gloss(VplList list) {
  for (Vpl& vpl : list.vpls) vpl.set_gloss(-1);
  list.gloss.clear();
  return list;
}

// Light of one part of the VPLs. shape: material x set
struct Emissions {
  std::vector<std::vector<double>> full, gap;
  Emissions(std::size_t materials, std::size_t sets)
      : full(materials, std::vector<double>(sets)), gap(full) {}
};

struct PartParams {
  VplList VplSet::*part;
  std::string stream;
  std::size_t sets;
  std::size_t stride;
};

// The sets of one part for some of the materials; they share their VPLs, which the first one's paths leave.
Emissions estimate_part(const ProofScene& scene, const ProofParams& params, const PartParams& part,
                        const std::vector<std::size_t>& which, const std::vector<PathTraced>& paths) {
  Emissions emissions(which.size(), part.sets);
  std::vector<double> thresholds;
  for (std::size_t i : which) thresholds.push_back(kRouletteShare * paths[i].mean.mean);
  for_each_parallel(part.sets, [&](std::size_t set) {
    const VplList vpls = std::move(trace_vpls(scene.world, scene.materials[which.front()], params.vpl_paths,
                                              params.seed + set, part.stream, Emission::kFull).*
                                   part.part);
    const auto points = take_every(scene.points, part.stride, set % part.stride);
    const ShadowRoulette roulette{thresholds, params.seed + set};
    const auto full = shade_means(scene, which, vpls, points, roulette);
    const auto lambertian = vpls.gloss.empty() || !params.with_gap
                                ? full
                                : shade_means(scene, which, without_gloss(vpls), points, roulette);
    for (std::size_t m = 0; m < which.size(); ++m) {
      emissions.full[m][set] = full[m] - paths[which[m]].excess_of(part.stride, set % part.stride);
      emissions.gap[m][set] = full[m] - lambertian[m];
    }
  });
  return emissions;
}

int count_own_sets(const Material& material, int all) {
  if (!(material.glossy_share > 0)) return kFewestOwnSets;
  const float share = std::min(1.0f, max_component(material.rho_s) / (material.alpha * kPeakOfAllSets));
  return std::max(kFewestOwnSets, static_cast<int>(share * static_cast<float>(all)));
}

std::vector<std::size_t> count_up(std::size_t size) {
  std::vector<std::size_t> numbers(size);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

}  // namespace

ProofEstimate find_relative_difference(const ProofEstimate& vpls, const ProofEstimate& paths) {
  EQ_CHECK(paths.mean > 0, paths.mean);
  return {vpls.mean / paths.mean - 1, std::hypot(vpls.standard_error, paths.standard_error) / paths.mean};
}

std::vector<Proof> make_proofs(const Scene& scene, const std::vector<MaterialSpec>& specs,
                               const ProofParams& params) {
  const World world = make_world(scene, params.geometry, params.illumination);
  std::vector<Materials> materials;
  for (const MaterialSpec& spec : specs) materials.push_back(make_materials(world, spec));
  const auto points = pick_points(scene, world, params);
  const ProofScene proof{world, materials, points};
  std::vector<PathTraced> paths;
  for (const Materials& each : materials) paths.push_back(trace_points(proof, each, params));
  const PartParams shared{&VplSet::shared, "proof.shared", static_cast<std::size_t>(params.sets),
                          kProofStride};
  const Emissions common = estimate_part(proof, params, shared, count_up(specs.size()), paths);
  std::vector<Proof> proofs;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const int own_sets = count_own_sets(materials[i][kObjectMaterial], params.own_sets);
    const PartParams part{&VplSet::own, "proof.own." + specs[i].name, static_cast<std::size_t>(own_sets), 1};
    const Emissions own = estimate_part(proof, params, part, {i}, paths);
    proofs.push_back({paths[i].mean, add_independent(summarise(common.full[i]), summarise(own.full[0])),
                      add_independent(summarise(common.gap[i]), summarise(own.gap[0]))});
  }
  return proofs;
}

}  // namespace equilux
