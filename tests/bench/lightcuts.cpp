// Lightcuts of the café at the paper's settings: times side by side in one run, and a table of their ratios
// with what they must be. Leaves with 1 if one is missed.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>

#include "renderer/lightcut.h"
#include "renderer/parallel.h"

namespace {

using namespace equilux;

constexpr int kWidth = 560, kHeight = 420, kSamples = 4;
constexpr double kRatio = 0.0075;
constexpr double kFloor = 1e-4;  // about a quarter of a displayed step in this room
const std::vector<std::string> kMaterials{"MS", "MR", "GS", "LG"};

double seconds_of(const auto& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

const Scene& cafe() {
  static const Scene scene =
      load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  return scene;
}

std::vector<double> all_clamps() {
  std::vector<double> clamps;
  for (int level = 0; level < kClampLevelCount; ++level) clamps.push_back(clamp_per_m2(level));
  return clamps;
}

// Every `stride`-th run of kCutBlock pixels, which cuts take together.
std::vector<ShadingPoint> take_pixels(const std::vector<ShadingPoint>& all, std::size_t stride) {
  std::vector<ShadingPoint> points;
  std::size_t pixel = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    pixel += i > 0 && all[i].pixel != all[i - 1].pixel;
    if (pixel / kCutBlock % stride == 0) points.push_back(all[i]);
  }
  return points;
}

struct Room {
  World world;
  std::map<int, std::vector<ShadingPoint>> points;  // by samples a pixel

  explicit Room(const std::string& geometry) : world(make_world(cafe(), geometry, Illumination::kIndirect)) {
    for (int samples : {1, 4, 16})
      points[samples] =
          find_shading_points(trace_primary(world, make_view_camera(cafe(), 0), kWidth, kHeight, samples));
  }

  Material material(const std::string& name) const { return make_material(find_material(cafe(), name)); }
};

struct Lights {
  LightTree tree;
  double trace_seconds = 0, build_seconds = 0;

  Lights(const Room& room, std::int64_t count) {
    VplList list;
    trace_seconds = seconds_of([&] {
      const Materials materials = make_materials(room.world, find_material(cafe(), "MS"));
      VplSet set = trace_vpls(room.world, materials, find_path_count(room.world, count, 1), 1, "bench");
      list = std::move(set.shared);
      list.append(set.own);
    });
    build_seconds = seconds_of([&] { tree = make_light_tree(std::move(list), {1, 4}); });
  }

  // Of the same VPLs.
  Lights(const Lights& lights, int leaf_size)
      : tree(make_light_tree(VplList(lights.tree.vpls), {1, leaf_size})) {}

  double million() const { return static_cast<double>(tree.vpls.size()) / 1e6; }
  double bytes_each() const {
    const double bytes =
        static_cast<double>(tree.vpls.size() * sizeof(Vpl) + tree.vpls.gloss.size() * sizeof(VplGloss) +
                            tree.nodes.size() * sizeof(LightNode) + tree.gloss.size() * sizeof(GlossCluster));
    return bytes / static_cast<double>(tree.vpls.size());
  }
};

// Times of each benchmark; random interleaving puts what is compared side by side.
class Collector : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
      seconds_[run.run_name.function_name].push_back(run.real_accumulated_time /
                                                     static_cast<double>(run.iterations));
    }
  }

  double median(const std::string& name) const {
    const auto found = seconds_.find(name);
    if (found == seconds_.end())
      throw std::runtime_error(name + " was not run: the table needs all, without --benchmark_filter");
    std::vector<double> seconds = found->second;
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
  }

 private:
  std::map<std::string, std::vector<double>> seconds_;
};

void add(const std::string& name, std::function<void()> body) {
  benchmark::RegisterBenchmark(name.c_str(),
                               [body](benchmark::State& state) {
                                 for (auto _ : state) body();
                               })
      ->Iterations(1)
      ->Repetitions(3)
      ->UseRealTime()
      ->MeasureProcessCPUTime();
}

struct Row {
  std::string figure;
  double value = 0;
  double must = 0, reach = 0;
  bool at_least = false;
  bool enforced = true;
  bool holds() const { return !enforced || (at_least ? value >= must : value <= must); }
};

class Bench {
 public:
  int run() {
    for (const char* geometry : {"G0", "G2"}) add_geometry(geometry);
    add_leaves();
    Collector collector;
    benchmark::RunSpecifiedBenchmarks(&collector);
    bool holds = true;
    for (const char* geometry : {"G0", "G2"}) holds &= print(geometry, collector);
    print_leaves(collector);
    return holds ? 0 : 1;
  }

 private:
  void add_geometry(const std::string& geometry) {
    const Room& room = *(rooms_[geometry] = std::make_unique<Room>(geometry));
    const auto points = take_pixels(room.points.at(kSamples), kStride),
               singles = take_pixels(room.points.at(1), kStride);
    for (const char* count : {"100k", "1M", "5M", "25M"}) {
      const Lights& lights = *(lights_[geometry + "/" + count] =
                                   std::make_unique<Lights>(room, parse_vpl_count(count, "bench")));
      add_cut(geometry + "/MS/" + count, room, lights, points, {"MS"}, all_clamps());
      add_cut(geometry + "/single/" + count, room, lights, singles, {"MS"}, all_clamps());
    }
    const Lights& lights = *lights_[geometry + "/5M"];
    for (const std::string& name : kMaterials) {
      if (name != "MS") add_cut(geometry + "/" + name + "/5M", room, lights, points, {name}, all_clamps());
      for (int level = 0; level < kClampLevelCount; ++level)
        add_cut(fmt::format("{}/{}/5M/C{}", geometry, name, level), room, lights, points, {name},
                {clamp_per_m2(level)});
      add_rays(geometry + "/rays/" + name, room, lights, points, name);
    }
    add_cut(geometry + "/five", room, lights, points, kFive, all_clamps());
    for (const std::string& name : kFive)
      add_cut(geometry + "/five/" + name, room, lights, points, {name}, all_clamps());
    add_cut(geometry + "/sixteen", room, lights, take_pixels(room.points.at(16), kStride), {"MS"},
            all_clamps());
    const Lights& plain = *lights_[geometry + "/100k"];
    const auto some = take_pixels(room.points.at(kSamples), 4 * kStride);
    add_cut(geometry + "/some", room, plain, some, {"MS"}, all_clamps());
    add(geometry + "/plain", [&room, &plain, some] {
      shade_all_vpls(room.world, some, plain.tree.vpls, {room.material("MS")}, all_clamps(), [](double) {});
    });
  }

  void add_leaves() {
    const Room& room = *rooms_.at("G0");
    const auto points = take_pixels(room.points.at(kSamples), kStride);
    for (const char* count : kLeafCounts) {
      for (int leaf_size : kLeafSizes) {
        const Lights& lights = *(lights_[leaf_name(count, leaf_size)] = std::make_unique<Lights>(
                                     *lights_.at(fmt::format("G0/{}", count)), leaf_size));
        add_cut(leaf_name(count, leaf_size), room, lights, points, {"MS"}, all_clamps());
      }
    }
  }

  void print_leaves(const Collector& times) const {
    const Room& room = *rooms_.at("G0");
    const auto points = take_pixels(room.points.at(kSamples), kStride);
    fmt::print(
        "\nMost VPLs in a leaf; G0, MS, four samples a pixel\n\n| VPLs | leaf | clusters | time | bytes for "
        "each VPL |\n|---|---|---|---|---|\n");
    for (const char* count : kLeafCounts) {
      for (int leaf_size : kLeafSizes) {
        const std::string name = leaf_name(count, leaf_size);
        const Lights& lights = *lights_.at(name);
        CutRecord record;
        shade_lightcut(room.world, points, lights.tree, {room.material("MS")}, all_clamps(), {kRatio, kFloor},
                       &record);
        const double clusters = std::accumulate(record.sizes.begin(), record.sizes.end(), 0.0);
        fmt::print("| {} | {} | {:.0f} | {:.2f} | {:.1f} |\n", count, leaf_size,
                   clusters / static_cast<double>(points.size()),
                   times.median(name) / times.median(leaf_name(count, 4)), lights.bytes_each());
      }
    }
  }

  static std::string leaf_name(const std::string& count, int leaf_size) {
    return fmt::format("leaves/{}/{}", count, leaf_size);
  }

  // The shadow rays of a cut, in its order, by each of Embree's queries.
  void add_rays(const std::string& name, const Room& room, const Lights& lights,
                const std::vector<ShadingPoint>& points, const std::string& material) {
    std::vector<ShadowRay>& rays = rays_[name];
    std::mutex mutex;
    LightcutParams params{kRatio, kFloor};
    params.watch_rays = [&](const PointPacket& from, const PointPacket& to, std::uint32_t valid) {
      const std::lock_guard lock(mutex);
      for (std::size_t i = 0; i < from.x.size(); ++i) {
        if ((valid >> i) & 1u)
          rays.push_back({{from.x[i], from.y[i], from.z[i]}, {to.x[i], to.y[i], to.z[i]}});
      }
    };
    {
      const ThreadLimit in_order(1);
      shade_lightcut(room.world, points, lights.tree, {room.material(material)}, all_clamps(), params);
    }
    for (OcclusionQuery query : kOcclusionQueries)
      add(fmt::format("{}/{}", name, static_cast<int>(query)),
          [&room, &rays, query] { benchmark::DoNotOptimize(room.world.count_visible(rays, query)); });
  }

  static void add_cut(const std::string& name, const Room& room, const Lights& lights,
                      std::vector<ShadingPoint> points, const std::vector<std::string>& names,
                      std::vector<double> clamps) {
    std::vector<Material> materials;
    for (const std::string& material : names) materials.push_back(room.material(material));
    add(name, [&room, &lights, points = std::move(points), materials, clamps = std::move(clamps)] {
      shade_lightcut(room.world, points, lights.tree, materials, clamps, {kRatio, kFloor});
    });
  }

  bool print(const std::string& geometry, const Collector& times) const {
    const auto seconds = [&](const std::string& name) { return times.median(geometry + "/" + name); };
    const auto lights = [&](const std::string& count) -> const Lights& {
      return *lights_.at(geometry + "/" + count);
    };
    double levels = 0;
    for (const std::string& name : kMaterials) {
      double dearest = 0;
      for (int level = 0; level < kClampLevelCount; ++level)
        dearest = std::max(dearest, seconds(fmt::format("{}/5M/C{}", name, level)));
      levels = std::max(levels, seconds(name + "/5M") / dearest);
    }
    double separately = 0;
    for (const std::string& name : kFive) separately += seconds("five/" + name);
    std::vector<Row> rows;
    for (const std::string& name : kMaterials) {
      double best = std::numeric_limits<double>::infinity();
      for (OcclusionQuery query : kOcclusionQueries)
        best = std::min(best, seconds(fmt::format("rays/{}/{}", name, static_cast<int>(query))));
      rows.push_back({"shading / the same shadow rays by the best query, 5M, " + name,
                      seconds(name + "/5M") / best, 1.5, 1.15});
    }
    const double one = seconds("single/5M"), whole = one * kStride;
    const std::vector<Row> others{
        {"eleven levels / the dearest single level, worst material, 5M", levels, 1.5, 1.2},
        {"time at 25M / time at 100k, MS, one sample a pixel", seconds("single/25M") / seconds("single/100k"),
         2, 1.5},
        {"the same, four samples a pixel", seconds("MS/25M") / seconds("MS/100k"), 2, 1.5, false, false},
        {"exponent of time in the VPL count, 100k to 25M, one sample a pixel",
         find_exponent(seconds, "single"), 0.13, 0.08},
        {"the same, four samples a pixel", find_exponent(seconds, "MS"), 0.13, 0.08, false, false},
        {"plain sum / lightcuts at 100k, MS", seconds("plain") / seconds("some"), 30, 100, true},
        {"five materials x eleven levels together / separately, 5M", seconds("five") / separately, 0.5, 0.3},
        {"bytes for each VPL at 25M", lights("25M").bytes_each(), 80, 48},
        {"four samples a pixel / one, time", seconds("MS/5M") / one, 3.2, 2},
        {"sixteen samples a pixel / one, time", seconds("sixteen") / one, 10, 5},
        {"tree build, million VPLs/s at 25M", lights("25M").million() / lights("25M").build_seconds, 4, 10,
         true, false},
        {"VPL tracing, million VPLs/s", lights("25M").million() / lights("25M").trace_seconds, 6, 15, true,
         false},
        {"560 x 420, MS, 5M, eleven levels, 1 sample, seconds", whole, 4, 2, false, false},
        {"the same with 4 samples, seconds", seconds("MS/5M") * kStride, 12, 5, false, false}};
    rows.insert(rows.end(), others.begin(), others.end());
    fmt::print("\n{}, {} threads\n\n| figure | measured | must | reach for | |\n|---|---|---|---|---|\n",
               geometry, count_threads());
    bool holds = true;
    for (const Row& row : rows) {
      holds &= row.holds();
      fmt::print("| {} | {:.3g} | {} | {:g} | {} |\n", row.figure, row.value,
                 row.enforced ? fmt::format("{:g}", row.must) : fmt::format("({:g})", row.must), row.reach,
                 !row.enforced ? "reported"
                 : row.holds() ? "holds"
                               : "MISSED");
    }
    return holds;
  }

  // Slope of log time over log count, by least squares.
  static double find_exponent(const auto& seconds, const std::string& series) {
    const std::vector<std::pair<std::string, double>> counts{
        {"100k", 1e5}, {"1M", 1e6}, {"5M", 5e6}, {"25M", 2.5e7}};
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const auto& [name, count] : counts) {
      const double x = std::log(count), y = std::log(seconds(series + "/" + name));
      sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    const auto n = static_cast<double>(counts.size());
    return (n * sxy - sx * sy) / (n * sxx - sx * sx);
  }

  static constexpr std::array kLeafCounts{"100k", "1M", "5M"};
  static constexpr std::array kLeafSizes{1, 2, 4, 8};
  static constexpr std::size_t kStride = 32;
  const std::vector<std::string> kFive{"MS", "MR", "BS", "BR", "GS"};
  std::map<std::string, std::unique_ptr<Room>> rooms_;
  std::map<std::string, std::unique_ptr<Lights>> lights_;
  std::map<std::string, std::vector<ShadowRay>> rays_;
};

}  // namespace

int main(int argc, char** argv) {
  char interleave[] = "--benchmark_enable_random_interleaving=true";
  std::vector<char*> arguments(argv, argv + argc);
  arguments.push_back(interleave);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  try {
    return Bench().run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
