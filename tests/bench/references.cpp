// What each measure against noise gains for references of the café at equal time; prints a Markdown table.
#include <ctime>
#include <fmt/format.h>

#include "renderer/reference.h"

namespace {

using namespace equilux;

constexpr int kWidth = 140, kHeight = 105, kPaths = 128;

struct Outcome {
  DisplayNoise noise;
  double seconds = 0;  // of the processor, all threads
};

class Stage {
 public:
  Stage(const Scene& scene, const Object& object)
      : world_(make_world(scene, object.geometry, object.illumination)),
        materials_(make_materials(world_, find_material(scene, object.material))),
        primary_(trace_primary(world_, make_view_camera(scene, 0), kWidth, kHeight, 1)) {}

  Outcome trace(const ReferenceParams& params) const {
    const std::clock_t start = std::clock();
    const auto layers = trace_family({world_, materials_, primary_}, params, {[](double) {}, [](double) {}});
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    const HdrImage reference = composite({&layers.background, &layers.direct, &layers.indirect});
    const HdrImage coverage = make_coverage(primary_);
    const ToneCurve tone = make_tone_curve(reference, coverage, ToneMapping{});
    return {measure_display_noise(reference, layers.standard_error, coverage, tone), seconds};
  }

 private:
  World world_;
  Materials materials_;
  Primary primary_;
};

ReferenceParams fixed(const PathMeasures& measures) {
  ReferenceParams params;
  params.fixed = PathCounts{kPaths, kPaths, kPaths};
  params.stream_name = params.background_stream_name = "bench";
  params.measures = measures;
  return params;
}

double cost(const Outcome& outcome) {
  return outcome.noise.object_mean * outcome.noise.object_mean * outcome.seconds;
}

// Allotted paths against even ones: the even ones' time to the same three figures.
double gain_of_allotment(const Stage& stage, const Outcome& even) {
  ReferenceParams params;
  params.stream_name = params.background_stream_name = "bench";
  params.target = {3, 9, 6};
  const Outcome allotted = stage.trace(params);
  const double worst = std::max({even.noise.object_mean / allotted.noise.object_mean,
                                 even.noise.object_p99 / allotted.noise.object_p99,
                                 even.noise.outside_mean / allotted.noise.outside_mean});
  return even.seconds * worst * worst / allotted.seconds;
}

void print_row(const Scene& scene, const Object& object) {
  const Stage stage(scene, object);
  const Outcome all = stage.trace(fixed({}));
  PathMeasures draws, lights, roulette;
  draws.low_discrepancy = false;
  lights.emitter_mis = false;
  roulette.roulette = false;
  const auto gain = [&](const PathMeasures& measures) {
    return cost(stage.trace(fixed(measures))) / cost(all);
  };
  fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", format_key(object), gain(draws), gain(lights),
             gain(roulette), gain_of_allotment(stage, all));
  std::fflush(stdout);
}

}  // namespace

int main() {
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  fmt::print(
      "| object | low discrepancy | MIS of lamps | roulette by albedo | allotted paths "
      "|\n|---|---|---|---|---|\n");
  for (const auto& [geometry, material, illumination] : {std::tuple{"G0", "MS", Illumination::kIndirect},
                                                         {"G2", "MR", Illumination::kIndirect},
                                                         {"G0", "GS", Illumination::kIndirect},
                                                         {"G0", "MS", Illumination::kDirectAndIndirect}})
    print_row(scene, {geometry, material, illumination});
}
