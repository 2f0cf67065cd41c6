// A scene, a method, a picture.
#include "renderer/picture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/progress.h"
#include "renderer/compensation.h"
#include "renderer/cut_error.h"
#include "renderer/lightcut.h"
#include "renderer/reference.h"
#include "renderer/shade.h"
#include "renderer/vpl_sets.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {

struct PictureScene {
  World world;
  Materials materials;
  std::string stream_name, background_stream_name;
  Primary primary;
};

PictureScene make_all_sculptures(const Scene& scene, const PictureParams& params) {
  if (params.material) {
    throw InputError("--material", "", "a geometry to give it to: the scene has sculptures",
                     *params.material);
  }
  World world = make_sculpture_world(scene, params.illumination);
  std::vector<MaterialSpec> own;
  for (const Sculpture& sculpture : scene.sculptures) own.push_back(find_material(scene, sculpture.material));
  Materials materials = make_materials(world, own);
  const std::string stream =
      fmt::format("sculptures-{}-v{}", format_illumination(params.illumination), params.view);
  return {std::move(world), std::move(materials), stream, stream, {}};
}

PictureScene make_one_object(const Scene& scene, const PictureParams& params) {
  const std::string geometry = params.geometry.value_or("G0");
  const std::string material = params.material.value_or(default_material(scene, geometry));
  World world = make_world(scene, geometry, params.illumination);
  Materials materials = make_materials(world, find_material(scene, material));
  // A set's own, so that its reference is this picture.
  const Family family{{geometry, material, params.illumination}, params.view};
  return {std::move(world), std::move(materials), format_key(family), name_background_stream(family), {}};
}

PictureScene make_picture_scene(const PictureParams& params) {
  const Scene scene = load_scene(params.scene_path);
  const bool all = !scene.sculptures.empty() && !params.geometry;
  PictureScene made = all ? make_all_sculptures(scene, params) : make_one_object(scene, params);
  const Camera camera = params.camera.value_or(make_view_camera(scene, params.view));
  made.primary = trace_primary(made.world, camera, params.width, params.height, params.positions);
  return made;
}

double clamp_of(const PictureParams& params, const std::string& object) {
  const auto found = params.clamps_by_object.find(object);
  return found == params.clamps_by_object.end() ? params.clamp_per_m2 : found->second;
}

void check_clamps(const PictureParams& params, const World& world) {
  std::string known;
  for (const std::string& name : world.objects()) known += (known.empty() ? "" : ", ") + name;
  for (const auto& [name, clamp] : params.clamps_by_object) {
    if (std::find(world.objects().begin(), world.objects().end(), name) == world.objects().end())
      throw InputError("--clamp", name, "an object of the picture: " + known, name);
  }
}

constexpr int kRoughPaths = 16;

HdrImage trace_rough_indirect(const PictureScene& scene, const PictureParams& params) {
  PathMaps maps = make_fixed_maps(scene.primary, {kRoughPaths, kRoughPaths, kRoughPaths});
  maps.background = maps.direct = PathMap(maps.indirect.size(), 0);
  return trace_layers({scene.world, scene.materials, scene.primary}, maps, params.seed,
                      scene.stream_name + ".floor", {}, [](double) {})
      .indirect.mean;
}

// A quarter of a displayed step, through the curve of the background and direct light that are there already;
// where both are black, through that of a few paths' indirect light.
double find_floor(const PictureParams& params, const Picture& picture, const PictureScene& scene) {
  std::vector<const HdrImage*> layers{&picture.background};
  for (const ObjectLayers& object : picture.objects) layers.push_back(&object.direct);
  HdrImage known = composite(layers);
  const auto is_zero = [](float value) { return value == 0; };
  if (std::all_of(known.values.begin(), known.values.end(), is_zero))
    known = trace_rough_indirect(scene, params);
  const ToneMapping tone{ToneOperator::kGlobal, params.tone.key, params.tone.exposure};
  return find_radiance_of_step(make_tone_curve(known, make_coverage(scene.primary), tone).record,
                               kFloorSteps);
}

// All VPLs: as a list where they are few, else as a tree.
struct Lights {
  VplList list;
  LightTree tree;
  double floor = 0;
};

// The object's layer at its own clamp, and unclamped where it is to be normalised to that.
HdrImage shade_object(const PictureScene& scene, const PictureParams& params, std::int32_t object,
                      const Lights& lights, Progress& progress, std::optional<CutMeasures>& measures) {
  const auto points = find_shading_points(scene.primary, object);
  const auto index = static_cast<std::size_t>(object);
  std::vector<double> clamps{clamp_of(params, scene.world.objects()[index])};
  if (params.normalise) clamps.push_back(std::numeric_limits<double>::infinity());
  const Material& material = scene.materials[index];
  ShadedPoints shaded;
  if (lights.tree.empty()) {
    shaded = shade_all_vpls(scene.world, points, lights.list, {material}, clamps,
                            [&](double pairs) { progress.advance(pairs); });
  } else {
    const auto advance = [&](double done) {
      progress.advance(done * static_cast<double>(lights.tree.vpls.size()));
    };
    MeasuredCut cut = shade_measured({scene.world, points, {&lights.tree}, material, clamps, advance},
                                     {kErrorRatio, lights.floor, params.certified}, params.seed);
    shaded = std::move(cut.shaded);
    measures = std::move(cut.measures);
  }
  std::vector<HdrImage> layers(clamps.size(), HdrImage(scene.primary.width, scene.primary.height));
  for (std::size_t level = 0; level < clamps.size(); ++level)
    add_to_layer(shaded, 0, level, points, scene.primary.positions, layers[level]);
  return params.normalise ? normalise_luminance(layers[0], layers[1]) : layers[0];
}

void shade_objects(const PictureScene& scene, const PictureParams& params, Picture& picture) {
  const std::int64_t path_count =
      find_path_count(scene.world, *params.vpl_count, params.seed, params.emission);
  Lights lights;
  lights.floor = find_floor(params, picture, scene);
  with_vpl_memory(*params.vpl_count, [&] {
    VplSet vpls = trace_vpls(scene.world, scene.materials, path_count, params.seed, "vpls", params.emission);
    picture.vpl_count = vpls.count();
    lights.list = join_vpls(std::move(vpls));
    if (!is_summed_plainly(*params.vpl_count))
      lights.tree = make_light_tree(std::move(lights.list), {params.seed, 4});
  });
  double points = 0;
  for (const PrimaryHit& hit : scene.primary.hits) points += hit.kind == PrimaryKind::kObject;
  Progress progress("shading", points * static_cast<double>(picture.vpl_count));
  for (std::size_t i = 0; i < picture.objects.size(); ++i) {
    ObjectLayers& object = picture.objects[i];
    object.indirect =
        shade_object(scene, params, static_cast<std::int32_t>(i), lights, progress, object.measures);
  }
}

void add_in_quadrature(HdrImage& sum, const HdrImage& more) {
  for (std::size_t i = 0; i < sum.values.size(); ++i)
    sum.values[i] = std::hypot(sum.values[i], more.values[i]);
}

// As shade_objects, by several sets, whose spread joins the standard error.
void shade_sets(const PictureScene& scene, const PictureParams& params, Picture& picture,
                HdrImage& standard_error) {
  VplSetsParams sets;
  sets.sets = *params.sets;
  sets.paths = find_path_count(scene.world, *params.vpl_count, params.seed, params.emission);
  for (const ObjectLayers& object : picture.objects) sets.clamps_per_m2.push_back(object.clamp_per_m2);
  sets.floor = find_floor(params, picture, scene);
  sets.emission = params.emission;
  sets.seed = params.seed;
  sets.stream_name = scene.stream_name + ".vpls";
  Progress progress("VPL sets", 1.0 + count_vpl_sets(sets.sets, scene.primary.positions));
  VplSets traced;
  with_vpl_memory(*params.vpl_count, [&] {
    traced =
        trace_vpl_sets({scene.world, scene.materials, scene.primary}, sets, [&] { progress.advance(1); });
  });
  picture.vpl_count = std::llround(traced.mean_vpls);
  picture.sets = traced.sets;
  for (std::size_t i = 0; i < picture.objects.size(); ++i) {
    picture.objects[i].indirect = std::move(traced.layers[i].mean);
    add_in_quadrature(standard_error, traced.layers[i].standard_error);
  }
}

ReferenceParams make_params(const PictureParams& params, const PictureScene& scene) {
  ReferenceParams reference;
  if (params.noise_target) {
    reference.target = *params.noise_target;
  } else {
    reference.fixed = params.paths;
  }
  reference.tone = params.tone;
  reference.seed = params.seed;
  reference.stream_name = scene.stream_name;
  reference.background_stream_name = scene.background_stream_name;
  return reference;
}

// The room, then each object by itself; gives the standard error of their sum.
HdrImage trace_path_layers(const PictureScene& scene, const PictureParams& params, Picture& picture) {
  const ReferenceParams reference = make_params(params, scene);
  Progress progress("path tracing", estimate_background_paths(reference, scene.primary) +
                                        estimate_object_paths(reference, scene.primary));
  const FamilyProgress report{[&](double paths) { progress.advance(paths); },
                              [&](double paths) { progress.expect_more(paths); }};
  const BackgroundPlan room = plan_background(scene.world, scene.primary, reference, report);
  PathMaps maps = allot_object({scene.world, scene.materials, scene.primary}, room, reference, report);
  PathMap compensation;
  const PathMap none(maps.indirect.size(), 0);
  if (params.vpl_count) {  // VPLs light the objects instead
    if (params.compensate) compensation = maps.indirect;
    maps.indirect = none;
  }
  picture.paths = count_paths(scene.primary, {room.map, maps.direct, maps.indirect});
  if (!compensation.empty()) picture.paths += count_paths(scene.primary, {none, none, compensation});
  std::vector<Background> background =
      trace_planned_backgrounds({scene.world, {&scene.materials, 1}, scene.primary}, room, reference, report);
  HdrImage standard_error = std::move(background[0].layer.standard_error);
  picture.background = std::move(background[0].layer.mean);
  for (std::size_t i = 0; i < scene.world.objects().size(); ++i) {
    const Primary part = isolate_object(scene.primary, static_cast<std::int32_t>(i));
    TracedLayers traced = trace_layers({scene.world, scene.materials, part}, maps, reference.seed,
                                       reference.stream_name, reference.measures, report.advance);
    add_in_quadrature(standard_error, combine_standard_errors(traced));
    const std::string& name = scene.world.objects()[i];
    picture.objects.push_back({name,
                               clamp_of(params, name),
                               make_coverage(part),
                               std::move(traced.direct.mean),
                               std::move(traced.indirect.mean),
                               {},
                               {}});
    if (compensation.empty()) continue;
    std::vector<TracedLayer> returned = trace_compensation({scene.world, scene.materials, part}, compensation,
                                                           {{clamp_of(params, name)},
                                                            params.emission,
                                                            reference.seed,
                                                            reference.stream_name,
                                                            reference.measures},
                                                           report.advance);
    add_in_quadrature(standard_error, returned[0].standard_error);
    picture.objects.back().compensation = std::move(returned[0].mean);
  }
  return standard_error;
}

HdrImage add_layers(const Picture& picture) {
  std::vector<const HdrImage*> layers{&picture.background};
  for (const ObjectLayers& object : picture.objects)
    layers.insert(layers.end(), {&object.direct, &object.indirect});
  return composite(layers);
}

}  // namespace

Picture make_picture(const PictureParams& params) {
  const PictureScene scene = make_picture_scene(params);
  check_clamps(params, scene.world);
  Picture picture;
  HdrImage standard_error = trace_path_layers(scene, params, picture);
  if (params.sets) {
    shade_sets(scene, params, picture, standard_error);
  } else if (params.vpl_count) {
    shade_objects(scene, params, picture);
  }
  for (ObjectLayers& object : picture.objects) {
    if (object.compensation) object.indirect = composite({&object.indirect, &*object.compensation});
  }
  picture.image = add_layers(picture);
  const HdrImage coverage = make_coverage(scene.primary);
  const ToneCurve tone = make_tone_curve(picture.image, coverage, params.tone);
  picture.display = apply_tone_curve(picture.image, tone);
  picture.noise_display =
      show_noise(measure_pixel_noise(picture.image, standard_error, tone), params.width, params.height);
  picture.noise = measure_display_noise(picture.image, standard_error, coverage, tone);
  return picture;
}

}  // namespace equilux
