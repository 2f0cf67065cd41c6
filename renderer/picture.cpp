// A scene, a method, a picture.
#include "renderer/picture.h"

#include "base/progress.h"
#include "renderer/reference.h"
#include "renderer/shade.h"

namespace equilux {
namespace {

HdrImage shade_object(const World& world, const Primary& primary, const PictureParams& params,
                      const Materials& materials, const VplSet& vpls) {
  const auto points = find_shading_points(primary);
  const double pairs = static_cast<double>(points.size()) * static_cast<double>(vpls.count());
  Progress progress("shading", pairs);
  HdrImage layer(primary.width, primary.height);
  for (const auto* part : {&vpls.shared, &vpls.own}) {
    const auto shaded = shade_all_vpls(world, points, *part, {materials[kObjectMaterial]},
                                       {params.clamp_per_m2}, [&](double done) { progress.advance(done); });
    add_to_layer(shaded, 0, 0, points, primary.positions, layer);
  }
  return layer;
}

LdrImage show_noise(const HdrImage& image, const HdrImage& standard_error, const ToneRecord& tone) {
  LdrImage shown(image.width, image.height);
  const std::vector<double> noise = measure_pixel_noise(image, standard_error, tone);
  for (std::size_t i = 0; i < shown.values.size(); ++i)
    shown.values[i] = static_cast<std::uint8_t>(std::min(255.0, 51 * noise[i / 3]));
  return shown;
}

FamilyLayers trace_path_layers(const FamilyScene& scene, const PictureParams& params) {
  ReferenceParams reference;
  if (params.noise_target) {
    reference.target = *params.noise_target;
  } else {
    reference.fixed = params.paths;
    if (params.vpl_count) reference.fixed->object_indirect = 1;  // VPLs light the object instead
  }
  reference.seed = params.seed;
  reference.stream_name = format_key(Family{params.object, params.view});
  Progress progress("path tracing", estimate_family_paths(reference, scene.primary));
  return trace_family(
      scene, reference,
      {[&](double paths) { progress.advance(paths); }, [&](double paths) { progress.expect_more(paths); }});
}

}  // namespace

Picture make_picture(const PictureParams& params) {
  const Scene scene = load_scene(params.scene_path);
  const MaterialSpec& object_material = find_material(scene, params.object.material);
  const World world = make_world(scene, params.object.geometry, params.object.illumination);
  const Materials materials = make_materials(world, object_material);
  const Primary primary = trace_primary(world, make_view_camera(scene, params.view), params.width,
                                        params.height, params.positions);
  const FamilyLayers traced = trace_path_layers({world, materials, primary}, params);
  Picture picture;
  if (params.vpl_count) {
    const std::int64_t path_count = find_path_count(world, *params.vpl_count, params.seed);
    const VplSet vpls = trace_vpls(world, materials, path_count, params.seed, "vpls", params.emission);
    picture.vpl_count = vpls.count();
    const HdrImage lit = shade_object(world, primary, params, materials, vpls);
    picture.image = composite({&traced.background, &traced.direct, &lit});
  } else {
    picture.image = composite({&traced.background, &traced.direct, &traced.indirect});
  }
  picture.paths = traced.paths;
  const HdrImage coverage = make_coverage(primary);
  const ToneRecord tone = make_tone_curve(picture.image, coverage, Exposure::kBackground, 0.18);
  picture.display = apply_tone_curve(picture.image, tone);
  picture.noise_display = show_noise(picture.image, traced.standard_error, tone);
  picture.noise = measure_display_noise(picture.image, traced.standard_error, coverage, tone);
  return picture;
}

}  // namespace equilux
