// A scene, the meshes that it makes in a moment, and its digest.
#include "stimuli/scene.h"

#include "tests/fuzz/fuzz.h"

namespace {

// Meshes that are allowed to be large are not made here.
bool is_small(const equilux::Scene& scene, const std::string& mesh) {
  std::int64_t size = 1;
  for (const std::string& name : list_used_meshes(scene, mesh)) {
    const equilux::Json& spec = scene.meshes.at(name);
    for (const char* kind : {"sphere", "blob"}) {
      if (const auto* found = spec.find(kind))
        size += std::int64_t{80} << (2 * found->at("subdivisions").as_int());
    }
    if (const auto* lathe = spec.find("lathe"))
      size += lathe->at("segments").as_int() * std::ssize(lathe->at("profile").as_array());
    if (const auto* sweep = spec.find("sweep"))
      size += sweep->at("segments").as_int() * sweep->at("steps").as_int() *
              std::ssize(sweep->at("points").as_array());
    if (const auto* scatter = spec.find("scatter")) size *= scatter->at("count").as_int();
    if (const auto* group = spec.find("group")) size *= std::ssize(group->as_array());
  }
  return size <= 20000;
}

void make_all(const equilux::Scene& scene) {
  using namespace equilux;
  bool small = true;
  for (const auto& [name, mesh] : scene.geometries) small = small && is_small(scene, mesh);
  for (const Instance& instance : scene.instances) small = small && is_small(scene, instance.mesh);
  if (!small) return;
  for (const auto& [name, mesh] : scene.geometries) {
    for (Vec3 p : make_object(scene, name).positions) EQ_CHECK(is_finite(p), name, p.x, p.y, p.z);
    digest_scene_part(scene, {name, scene.materials.front().name, Illumination::kIndirect});
  }
  for (const Instance& instance : scene.instances)
    place_mesh(make_mesh(scene, instance.mesh), instance.placement);
  make_view_camera(scene, 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  [[maybe_unused]] static const auto mesh =
      fuzz_folder().write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const auto path = fuzz_folder().write("scene.json", as_text(bytes, size));
  expect_read_or_refused("", [&] { make_all(load_scene(path)); });
  return 0;
}
