// VPLs, cuts, clamp and emission, each by itself.
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "base/progress.h"
#include "renderer/compensation.h"
#include "renderer/converge_lab.h"
#include "renderer/lightcut.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {

// Cuts that are held to be exact beside the study's own.
constexpr double kFineShare = 1.0 / 20;
// Of the parts that are measured by paths.
constexpr int kPartPaths = 1024;

// A mean of pixels that are independent; the channels of one go together.
struct LayerSummary {
  double square = 0, variance = 0, bias = 0, bias_error = 0;
};

LayerSummary summarise_layer(const ReferenceTruth& truth, const TracedLayer& layer) {
  const auto squared = [](double x) { return x * x; };
  LayerSummary summary;
  summary.square = truth.average([&](std::size_t i) { return squared(layer.mean.values[i]); }, 2);
  summary.variance = truth.average([&](std::size_t i) { return squared(layer.standard_error.values[i]); }, 2);
  summary.bias = truth.average([&](std::size_t i) { return double{layer.mean.values[i]}; }, 1);
  summary.bias_error = std::sqrt(summary.variance / static_cast<double>(truth.object_pixels()));
  return summary;
}

HdrImage make_difference(const HdrImage& a, const HdrImage& b) {
  HdrImage difference = a;
  for (std::size_t i = 0; i < a.values.size(); ++i) difference.values[i] -= b.values[i];
  return difference;
}

// Of the condition at each seed: its light by the study's rule and by cuts so fine that only the VPLs err.
struct SetRuns {
  std::vector<HdrImage> cut, fine;
};

HdrImage add_up(const Laboratory& lab, const ShadedPoints& shaded) {
  HdrImage layer(lab.primary.width, lab.primary.height);
  add_to_layer(shaded, 0, 0, lab.points, lab.primary.positions, layer);
  return layer;
}

SetRuns run_sets(const Laboratory& lab, const LitScene& scene) {
  const std::vector<double> clamps{clamp_per_m2(lab.level())};
  const std::vector<Material> materials{lab.materials[kObjectMaterial]};
  SetRuns runs;
  Progress progress("parts of the error", lab.params.seeds);
  for (int run = 0; run < lab.params.seeds; ++run) {
    if (is_summed_plainly(lab.vpls())) {
      const VplList list = trace_run_vpls(scene, lab.vpls(), lab.seed(run), nullptr);
      runs.fine.push_back(
          add_up(lab, shade_all_vpls(lab.world, lab.points, list, materials, clamps, [](double) {})));
      runs.cut.push_back(runs.fine.back());
    } else {
      const LightTree tree = make_run_tree(scene, lab.vpls(), lab.seed(run), nullptr);
      const auto cut = [&](double ratio) {
        return add_up(lab,
                      shade_lightcut(lab.world, lab.points, tree, materials, clamps, {ratio, scene.floor}));
      };
      runs.cut.push_back(cut(kErrorRatio));
      runs.fine.push_back(cut(kErrorRatio * kFineShare));
    }
    progress.advance(1);
  }
  return runs;
}

struct Moments {
  double mean_square = 0, bias = 0, bias_error = 0;
};

// Of layers that differ by their seeds.
Moments take_moments(const ReferenceTruth& truth, const std::vector<HdrImage>& layers) {
  const auto count = static_cast<double>(layers.size());
  Moments moments;
  std::vector<double> means;
  for (const HdrImage& layer : layers) {
    moments.mean_square +=
        truth.average([&](std::size_t i) { return double{layer.values[i]} * layer.values[i]; }, 2) / count;
    means.push_back(truth.average([&](std::size_t i) { return double{layer.values[i]}; }, 1));
    moments.bias += means.back() / count;
  }
  double squares = 0;
  for (const double mean : means) squares += (mean - moments.bias) * (mean - moments.bias);
  moments.bias_error = std::sqrt(squares / (count - 1) / count);
  return moments;
}

ErrorPart measure_sampling(const Laboratory& lab, const ReferenceTruth& truth, const SetRuns& runs,
                           const TracedLayer& returned) {
  HdrImage mean(lab.primary.width, lab.primary.height);
  const auto count = static_cast<float>(runs.fine.size());
  for (const HdrImage& layer : runs.fine) {
    for (std::size_t i = 0; i < mean.values.size(); ++i) mean.values[i] += layer.values[i] / count;
  }
  std::vector<HdrImage> deviations, errors;
  for (const HdrImage& layer : runs.fine) {
    deviations.push_back(make_difference(layer, mean));
    errors.push_back(make_difference(composite({&layer, &returned.mean}), truth.layers().indirect.mean));
  }
  const Moments unbiased = take_moments(truth, errors);
  return {
      "VPL sampling",
      fmt::format("the spread of {} VPL sets; bias: their mean with all that the clamp takes, less the "
                  "reference",
                  runs.fine.size()),
      std::sqrt(take_moments(truth, deviations).mean_square * count / (count - 1)), unbiased.bias,
      std::hypot(unbiased.bias_error, truth.error_of_mean(), summarise_layer(truth, returned).bias_error)};
}

ErrorPart measure_cuts(const ReferenceTruth& truth, const SetRuns& runs) {
  std::vector<HdrImage> differences;
  for (std::size_t i = 0; i < runs.cut.size(); ++i)
    differences.push_back(make_difference(runs.cut[i], runs.fine[i]));
  const Moments moments = take_moments(truth, differences);
  return {"lightcuts", "cuts at the study's ratio less those at a twentieth of it, set by set",
          std::sqrt(moments.mean_square), moments.bias, moments.bias_error};
}

// What a layer takes from the light: known by paths, so that its noise is subtracted.
ErrorPart measure_taken(const ReferenceTruth& truth, const TracedLayer& taken, const char* name,
                        std::string by) {
  const LayerSummary summary = summarise_layer(truth, taken);
  return {name, std::move(by), std::sqrt(std::max(0.0, summary.square - summary.variance)), -summary.bias,
          summary.bias_error};
}

}  // namespace

std::vector<ErrorPart> measure_parts(const Laboratory& lab, const ReferenceTruth& truth,
                                     const LitScene& scene) {
  const double unclamped = std::numeric_limits<double>::infinity();
  const auto trace = [&](int paths, std::vector<double> clamps, bool clamped_alone) {
    CompensationParams params;
    params.clamps_per_m2 = std::move(clamps);
    params.emission = lab.params.emission;
    params.seed = lab.params.seed;
    params.stream_name = "converge.parts";
    params.clamped_alone = clamped_alone;
    return trace_compensation(lab.family(), make_fixed_maps(lab.primary, {paths, paths, paths}).indirect,
                              params, [](double) {});
  };
  const double clamp = clamp_per_m2(lab.level());
  const auto returned = trace(kPartPaths, {clamp, unclamped}, false);
  const TracedLayer &whole = returned[0], &missing = returned[1];
  const SetRuns runs = run_sets(lab, scene);
  const std::string by_paths = fmt::format("{} compensating paths a pixel", kPartPaths);
  std::vector<ErrorPart> parts;
  const ErrorPart sampling = measure_sampling(lab, truth, runs, whole), cuts = measure_cuts(truth, runs);
  parts.insert(parts.end(), {sampling, cuts});
  parts.push_back(measure_taken(truth, trace(kPartPaths, {clamp}, true)[0], "clamping", by_paths));
  if (lab.params.emission == Emission::kLambertian)
    parts.push_back(measure_taken(truth, missing, "emission model",
                                  by_paths + ": gloss that Lambertian VPLs do not send on"));
  const ErrorPart systematic = measure_taken(truth, whole, "", "");
  std::vector<HdrImage> errors;
  for (const HdrImage& cut : runs.cut) errors.push_back(make_difference(cut, truth.layers().indirect.mean));
  const Moments measured = take_moments(truth, errors);
  const double noise = truth.rms_of_error() * truth.rms_of_error();
  parts.push_back({"these together", "clamping and emission as one, and the squares of the rest",
                   std::hypot(systematic.relative_rms, sampling.relative_rms, cuts.relative_rms),
                   systematic.bias + cuts.bias, std::hypot(systematic.bias_error, cuts.bias_error)});
  parts.push_back({"the picture", "less the reference, whose variance is subtracted",
                   std::sqrt(std::max(0.0, measured.mean_square - noise)), measured.bias,
                   std::hypot(measured.bias_error, truth.error_of_mean())});
  const LayerSummary few = summarise_layer(truth, trace(lab.least_paths(), {clamp}, false)[0]);
  parts.push_back({"Monte Carlo noise, if compensated",
                   fmt::format("standard error of {} compensating paths a pixel", lab.least_paths()),
                   std::sqrt(few.variance), few.bias + systematic.bias,
                   std::hypot(few.bias_error, systematic.bias_error)});
  return parts;
}

}  // namespace equilux
