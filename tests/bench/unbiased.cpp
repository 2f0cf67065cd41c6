// Independent VPL sets and compensation against path tracing, for every geometry and material of the café;
// prints a Markdown table of differences by part of the object. Not timed.
#include <CLI/CLI.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <fmt/format.h>

#include "base/error.h"
#include "renderer/compensation.h"
#include "renderer/vpl.h"
#include "renderer/vpl_sets.h"

namespace {

using namespace equilux;

constexpr int kWidth = 84, kHeight = 63, kPositions = 2, kSets = 64, kLevel = 5;
constexpr std::int64_t kVpls = 30000;
constexpr int kPilotPaths = 64, kCompensationPaths = 1024, kPaths = 4096;

enum Part { kMiddle, kSilhouette, kContact, kParts };

// By a pixel's first position on the object: the lowest sixth of it is near the pedestal.
std::vector<int> find_parts(const Scene& scene, const Primary& primary) {
  const HdrImage coverage = make_coverage(primary);
  float top = scene.stand.z;
  for (const PrimaryHit& hit : primary.hits) {
    if (hit.kind == PrimaryKind::kObject) top = std::max(top, hit.point.p.z);
  }
  std::vector<int> parts(coverage.pixel_count(), -1);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (int position = primary.positions; position-- > 0;) {
      const PrimaryHit& hit = primary.at(i, position);
      if (hit.kind != PrimaryKind::kObject) continue;
      const bool low = hit.point.p.z < scene.stand.z + (top - scene.stand.z) / 6;
      parts[i] = coverage.values[i] < 1 ? kSilhouette : low ? kContact : kMiddle;
    }
  }
  return parts;
}

struct PartSum {
  double mean = 0, variance = 0;
};

std::array<PartSum, kParts> sum_parts(const TracedLayer& layer, const std::vector<int>& parts) {
  std::array<PartSum, kParts> sums{};
  std::array<double, kParts> pixels{};
  const auto luminance_of = [](const HdrImage& image, std::size_t i) {
    const float* p = image.pixel(i);
    return double{luminance({p[0], p[1], p[2]})};
  };
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i] < 0) continue;
    const auto part = static_cast<std::size_t>(parts[i]);
    ++pixels[part];
    sums[part].mean += luminance_of(layer.mean, i);
    sums[part].variance += std::pow(luminance_of(layer.standard_error, i), 2);
  }
  for (std::size_t part = 0; part < kParts; ++part) {
    sums[part].mean /= pixels[part];
    sums[part].variance /= pixels[part] * pixels[part];
  }
  return sums;
}

HdrImage uncover(HdrImage layer, const HdrImage& coverage) {
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = layer.pixel(i)[c];
      value = coverage.values[i] > 0 ? std::max(0.0f, value / coverage.values[i]) : 0;
    }
  }
  return layer;
}

// Difference of the two methods over the light, its error, and t.
struct Difference {
  double relative = 0, error = 0, t = 0;
};

std::array<Difference, kParts> compare(const Scene& scene, const std::string& geometry,
                                       const std::string& material, std::uint64_t seed) {
  const World world = make_world(scene, geometry, Illumination::kIndirect);
  const Materials materials = make_materials(world, find_material(scene, material));
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), kWidth, kHeight, kPositions);
  const FamilyScene family{world, materials, primary};
  const std::vector<int> parts = find_parts(scene, primary);
  const auto map = [&](int paths) { return make_fixed_maps(primary, {paths, paths, paths}).indirect; };
  const PathMap none(parts.size(), 0);
  const auto trace = [&](int paths, const char* stream) {
    return trace_layers(family, {none, none, map(paths)}, seed, stream, {}, [](double) {}).indirect;
  };
  const double clamp = clamp_per_m2(kLevel);
  VplSetsParams params;
  params.sets = kSets;
  params.paths = find_path_count(world, kVpls, seed);
  params.seed = seed;
  params.clamps_per_m2 = {clamp};
  params.error_ratio = 0.02;
  params.floor = 1e-4;
  params.stream_name = "unbiased";
  params.totals.push_back(uncover(trace(kPilotPaths, "unbiased.pilot").mean, make_coverage(primary)));
  params.regions = parts;
  const VplSets sets = trace_vpl_sets(family, params, [] {});
  const TracedLayer returned =
      std::move(trace_compensation(family, map(kCompensationPaths),
                                   {{clamp}, Emission::kLambertian, seed, "unbiased", {}}, [](double) {})[0]);
  const auto more = sum_parts(returned, parts), traced = sum_parts(trace(kPaths, "unbiased.paths"), parts);
  std::array<Difference, kParts> differences;
  for (std::size_t part = 0; part < kParts; ++part) {
    const double difference = sets.regions[part].mean + more[part].mean - traced[part].mean;
    const double error = std::sqrt(std::pow(sets.regions[part].standard_error, 2) + more[part].variance +
                                   traced[part].variance);
    differences[part] = {difference / traced[part].mean, error / traced[part].mean, difference / error};
  }
  return differences;
}

std::string format_difference(const Difference& difference) {
  return fmt::format("{:+.2f} ± {:.2f}", 100 * difference.relative, 100 * difference.error);
}

struct Summary {
  double largest = 0, squares = 0;
  int count = 0;
};

void print_row(const Scene& scene, const std::string& geometry, const std::string& material,
               std::uint64_t seed, Summary& summary) {
  const auto differences = compare(scene, geometry, material, seed);
  double most = 0;
  for (const Difference& difference : differences) {
    if (std::abs(difference.t) > std::abs(most)) most = difference.t;
    summary.squares += difference.t * difference.t;
    ++summary.count;
  }
  summary.largest = std::max(summary.largest, std::abs(most));
  fmt::print("| {}-{} | {} | {} | {} | {:+.1f} |\n", geometry, material,
             format_difference(differences[kMiddle]), format_difference(differences[kSilhouette]),
             format_difference(differences[kContact]), most);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> geometries{"G0", "G1", "G2", "G3", "Bunny", "Dragon"};
  std::vector<std::string> materials{"MS", "MR", "BS", "BR", "GS", "LG"};
  std::uint64_t seed = 1;
  CLI::App app("Differences of VPL sets with compensation from path tracing, in standard errors");
  app.add_option("--geometries", geometries, "Of the café (all)")->delimiter(',');
  app.add_option("--materials", materials, "Of the café (all)")->delimiter(',');
  app.add_option("--seed", seed, "Seed (1)");
  CLI11_PARSE(app, argc, argv);
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  fmt::print("| object | middle, % | silhouettes, % | contact, % | largest t |\n|---|---:|---:|---:|---:|\n");
  Summary summary;
  std::string left_out;
  for (const std::string& geometry : geometries) {
    try {
      for (const std::string& material : materials) print_row(scene, geometry, material, seed, summary);
    } catch (const InputError& error) {  // its mesh was not fetched
      left_out += std::string("\nLeft out: ") + error.what() + "\n";
    }
  }
  const boost::math::students_t spread(kSets - kPositions);
  const double limit = boost::math::quantile(boost::math::complement(spread, 0.01 / summary.count / 2));
  fmt::print("\nLargest of {} |t|: {:.2f}; level 1 % over all of them: {:.2f}. Root mean square: {:.2f}.\n{}",
             summary.count, summary.largest, limit, std::sqrt(summary.squares / summary.count), left_out);
  return summary.largest < limit ? 0 : 1;
}
