// Scenes that a user might bring, at the edge of what numbers can hold.
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/reference.h"
#include "renderer/shade.h"
#include "renderer/stress.h"
#include "renderer/stress_scene.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr int kSize = 24;

struct Rendered {
  HdrImage path, vpl;
  std::size_t bad = 0;
  std::size_t object_pixels = 0;
};

Rendered render(const Scene& scene, const std::string& material, double clamp) {
  const World world = make_world(scene, "G0", Illumination::kDirectAndIndirect);
  const Materials materials = make_materials(world, find_material(scene, material));
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), kSize, kSize, 1);
  ReferenceParams params;
  params.fixed = PathCounts{32, 32, 32};
  params.stream_name = params.background_stream_name = "stress";
  const FamilyLayers layers =
      trace_family({world, materials, primary}, params, {[](double) {}, [](double) {}});
  Rendered rendered;
  rendered.path = composite({&layers.background, &layers.direct, &layers.indirect});
  rendered.vpl = HdrImage(kSize, kSize);
  const auto points = find_shading_points(primary);
  rendered.object_pixels = points.size();
  const VplSet vpls = trace_vpls(world, materials, 500, 1, "stress", Emission::kFull);
  for (const VplList* list : {&vpls.shared, &vpls.own}) {
    const auto shaded = shade_all_vpls(world, points, *list, {materials[0]}, {clamp}, [](double) {});
    add_to_layer(shaded, 0, 0, points, 1, rendered.vpl);
  }
  for (float value : rendered.path.values) rendered.bad += !std::isfinite(value);
  return rendered;
}

// A glossy blob on a floor before a wall, under a spot and a lamp, with every length times s and the
// intensity that keeps radiance.
Scene make_scaled_scene(double s) {
  const auto vec = [&](double x, double y, double z, double scale) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", x * scale, y * scale, z * scale);
  };
  StressText text;
  text.materials = R"([
    {"name": "metal", "model": "ward-duer", "rho_d": [0.03, 0.03, 0.03], "rho_s": [0.22, 0.22, 0.22], "alpha": 0.1},
    {"name": "room", "model": "lambertian", "rho_d": [0.6, 0.5, 0.4]}])";
  text.camera =
      fmt::format(R"({{"position": {}, "target": {}, "up": [0, 0, 1], "vertical_fov_degrees": 30}})",
                  vec(0, -3, 0.6, s), vec(0, 0, 0.4, s));
  text.meshes =
      fmt::format(R"([{{"name": "object", "blob": {{"radius": {:.17g}, "amplitude": 0.12, "frequency": 5,
    "seed": 1, "subdivisions": 4}}}}, {{"name": "floor", "quad": {{"u": {}, "v": {}}}}},
    {{"name": "wall", "quad": {{"u": {}, "v": {}}}}}])",
                  0.4 * s, vec(4, 0, 0, s), vec(0, 4, 0, s), vec(4, 0, 0, s), vec(0, 0, 3, s));
  text.instances = fmt::format(R"([{{"mesh": "floor", "material": "room", "at": {}}},
    {{"mesh": "wall", "material": "room", "at": {}}}])",
                               vec(-2, -2, 0, s), vec(-2, 2, 0, s));
  text.lights =
      fmt::format(R"([{{"spot": {{"position": {}, "target": {}, "inner_degrees": 20, "outer_degrees": 40,
    "intensity": {}}}}}, {{"rectangle": {{"corner": {}, "u": {}, "v": {}, "radiance": [5, 5, 5]}}}}])",
                  vec(1, -1, 2.5, s), vec(1, 1, 0, s), vec(9, 8, 7, s * s), vec(-1, -1, 2.5, s),
                  vec(0, 0.5, 0, s), vec(0.5, 0, 0, s));
  return make_stress_scene(text);
}

StressRow stress_scale(int exponent) {
  const double s = std::ldexp(1.0, exponent);
  const Rendered base = render(make_scaled_scene(1), "metal", 10);
  const Rendered scaled = render(make_scaled_scene(s), "metal", 10 / (s * s));
  std::size_t differing = 0;
  for (std::size_t i = 0; i < base.path.values.size(); ++i)
    differing += base.path.values[i] != scaled.path.values[i] || base.vpl.values[i] != scaled.vpl.values[i];
  return make_stress_row("scene", fmt::format("all lengths times 2^{}, c scaled along", exponent),
                         "the same picture to the last bit", fmt::format("{} values differ", differing),
                         differing == 0);
}

// An object from an OBJ file in the light of a spot; mesh text with faces, seen from the front.
Rendered render_mesh(const std::string& obj, MeshRepairs* repairs = nullptr) {
  const StressFolder folder;
  save_text(folder.path() / "mesh.obj", obj);
  if (repairs) load_mesh(folder.path() / "mesh.obj", repairs);
  StressText text;
  text.meshes = R"([{"name": "object", "file": {"path": "mesh.obj"}},
    {"name": "floor", "quad": {"u": [4, 0, 0], "v": [0, 4, 0]}}])";
  text.instances = R"([{"mesh": "floor", "material": "grey", "at": [-2, -2, -0.1]}])";
  text.lights = R"([{"spot": {"position": [0.5, -2, 2], "target": [0, 0, 0.3], "inner_degrees": 30,
    "outer_degrees": 50, "intensity": [5, 5, 5]}}])";
  return render(make_stress_scene(text, folder), "grey", 10);
}

double brightest(const HdrImage& image) {
  float largest = 0;
  for (float value : image.values) largest = std::max(largest, value);
  return largest;
}

double mean_of(const HdrImage& image) {
  double sum = 0;
  for (float value : image.values) sum += value;
  return sum / static_cast<double>(image.values.size());
}

constexpr const char* kSquare = "v -0.4 0 0\nv 0.4 0 0\nv 0.4 0 0.8\nv -0.4 0 0.8\n";

// A mesh that covers the same square must look as the square does. The VPL picture holds the object alone.
StressRow expect_square(const Rendered& plain, const std::string& what, const Rendered& rendered) {
  const double path = mean_of(rendered.path) / mean_of(plain.path) - 1;
  const double vpl = mean_of(rendered.vpl) / mean_of(plain.vpl) - 1;
  const bool same = rendered.object_pixels == plain.object_pixels;
  return make_stress_row(
      "mesh", what, "finite, the plain square's pixels, its light within 1 %",
      fmt::format("{} not finite, {} of {} pixels, light {:+.1e} path traced, {:+.1e} by VPLs", rendered.bad,
                  rendered.object_pixels, plain.object_pixels, path, vpl),
      rendered.bad == 0 && same && std::abs(path) < 0.01 && std::abs(vpl) < 0.01);
}

void add_meshes(std::vector<StressRow>& rows) {
  const std::string square = kSquare;
  const Rendered plain = render_mesh(square + "f 1 2 3\nf 1 3 4\n");
  MeshRepairs repairs;
  const Rendered zero = render_mesh(square + "v 0.4 0 0.4\nf 1 2 3\nf 1 3 4\nf 2 3 5\nf 1 1 2\n", &repairs);
  rows.push_back(expect_square(plain, "faces of zero area among others", zero));
  rows.push_back(make_stress_row("mesh", "faces of zero area among others", "two left out and counted",
                                 fmt::format("{} left out", repairs.degenerate_triangles),
                                 repairs.degenerate_triangles == 2));
  rows.push_back(expect_square(plain, "a sliver, 1e-6 of its length wide, on its upper edge",
                               render_mesh(square + "v 0 0 0.8000008\nf 1 2 3\nf 1 3 4\nf 3 5 4\n")));
  rows.push_back(expect_square(plain, "a triangle of 1e8 : 1 through it",
                               render_mesh("v -5000 0 0.4\nv 5000 0 0.4\nv 5000 0 0.4001\n" + square +
                                           "f 1 2 3\nf 4 5 6\nf 4 6 7\n")));
  rows.push_back(
      expect_square(plain, "normals of zero length and opposite to the faces",
                    render_mesh(square + "vn 0 0 0\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n")));
  rows.push_back(expect_square(plain, "coplanar faces, each twice",
                               render_mesh(square + "f 1 2 3\nf 1 3 4\nf 1 2 3\nf 4 3 1\n")));
}

// A spot inside a closed ball lights its inside only.
StressRow stress_light_inside() {
  StressText text;
  text.meshes = R"([{"name": "object", "sphere": {"radius": 0.4, "subdivisions": 5}},
    {"name": "floor", "quad": {"u": [4, 0, 0], "v": [0, 4, 0]}}])";
  text.instances = R"([{"mesh": "floor", "material": "grey", "at": [-2, -2, 0]}])";
  text.lights = R"([{"spot": {"position": [0, 0, 0.4], "target": [0, -1, 0.4], "inner_degrees": 60,
    "outer_degrees": 90, "intensity": [100, 100, 100]}}])";
  const Rendered rendered = render(make_stress_scene(text), "grey", 10);
  return make_stress_row("light", "inside the object", "no light outside",
                         fmt::format("brightest {:g} path traced, {:g} by VPLs", brightest(rendered.path),
                                     brightest(rendered.vpl)),
                         brightest(rendered.path) == 0 && brightest(rendered.vpl) == 0);
}

void add_black(std::vector<StressRow>& rows) {
  const Scene scene = make_stress_scene(kOpenSpace);
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), kSize, kSize, 1);
  ReferenceParams params;
  params.target = {1, 3, 2};
  params.stream_name = params.background_stream_name = "stress";
  const auto layers = trace_family({world, make_materials(world, scene.materials[0]), primary}, params,
                                   {[](double) {}, [](double) {}});
  const double largest = brightest(composite({&layers.background, &layers.direct, &layers.indirect}));
  rows.push_back(make_stress_row("scene", "no light reaches anything, path traced", "black",
                                 fmt::format("brightest {:g}", largest), largest == 0));
  rows.push_back(expect_input_error("scene", "no light reaches anything, VPLs",
                                    [&] { find_path_count(world, 1000, 1); }));
}

// A spot four micrometres before a wall, and a camera that sees the spot's own micrometres.
StressText strong_light(const char* intensity) {
  StressText text;
  text.camera =
      R"({"position": [0.5, -1, 0.5], "target": [0.5, 0, 0.5], "up": [0, 0, 1], "vertical_fov_degrees": 0.01})";
  text.meshes = R"([{"name": "object", "quad": {"u": [1, 0, 0], "v": [0, 0, 1]}}])";
  text.lights = fmt::format(R"([{{"spot": {{"position": [0.5, -4e-6, 0.5], "target": [0.5, 0, 0.5],
    "inner_degrees": 60, "outer_degrees": 90, "intensity": [{0}, {0}, {0}]}}}}])",
                            intensity);
  return text;
}

}  // namespace

StressFolder::StressFolder() {
  std::string name = (fs::temp_directory_path() / "equilux-stress-XXXXXX").string();
  if (!::mkdtemp(name.data())) throw StoreError(fmt::format("{}: expected a new folder, got none", name));
  path_ = name;
}

StressFolder::~StressFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

Scene make_stress_scene(const StressText& text, const StressFolder& folder) {
  const fs::path path = folder.path() / "scene.json";
  save_text(path,
            fmt::format(R"({{"schema": "equilux-scene", "schema_version": 1, "name": "stress", "camera": {},
    "materials": {}, "meshes": {}, "instances": {},
    "object": {{"stand": {}, "geometries": [{{"name": "G0", "mesh": "object"}}]}}, "lights": {}}})",
                        text.camera, text.materials, text.meshes, text.instances, text.stand, text.lights));
  return load_scene(path);
}

Scene make_stress_scene(const StressText& text) { return make_stress_scene(text, StressFolder()); }

std::vector<StressRow> stress_scenes() {
  std::vector<StressRow> rows{stress_scale(20), stress_scale(-20)};
  add_meshes(rows);
  rows.push_back(stress_light_inside());
  add_black(rows);
  rows.push_back(expect_input_error("light",
                                    "1e30 W/sr four micrometres before the object: radiance beyond float",
                                    [] { render(make_stress_scene(strong_light("1e30")), "grey", 10); }));
  rows.push_back(expect_input_error("light", "1e31 W/sr, more than a scene may say",
                                    [] { make_stress_scene(strong_light("1e31")); }));
  return rows;
}

}  // namespace equilux
