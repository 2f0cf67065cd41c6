// Each omission by its own predicate.
#include "renderer/plan.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "renderer/batches.h"
#include "renderer/compensation.h"
#include "renderer/lights.h"
#include "renderer/path_tracer.h"
#include "renderer/primary.h"
#include "renderer/vpl.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {

// Of the pictures and particles by which savings are counted.
constexpr int kProbeWidth = 140, kProbeHeight = 105;
constexpr std::int64_t kProbePaths = 20000;

struct Probe {
  const Scene& scene;
  const PlanRequest& request;
  const Object& object;
  World world;
  Materials materials;
  Primary primary;
  double object_share = 0;  // of the pixels

  Probe(const Scene& asked, const PlanRequest& plan)
      : scene(asked),
        request(plan),
        object(plan.condition.cell.column.object),
        world(make_world(scene, object.geometry, object.illumination)),
        materials(make_materials(world, find_material(scene, object.material))),
        primary(trace_primary(world, make_view_camera(scene, plan.condition.view), kProbeWidth, kProbeHeight,
                              1)) {
    for (const PrimaryHit& hit : primary.hits)
      object_share += hit.kind == PrimaryKind::kObject ? 1.0 / static_cast<double>(primary.hits.size()) : 0;
  }

  double object_points() const { return object_share * request.width * request.height * request.positions; }
  std::int64_t vpl_count() const { return request.condition.cell.column.vpl_count; }
};

std::string count_points(const Probe& probe) {
  return fmt::format("at about {:.0f} points of the object", probe.object_points());
}

Omission plan_gloss(const Probe& probe) {
  const bool left_out = probe.materials[kObjectMaterial].glossy_share == 0;
  return {"the object's glossy lobe, its bounds and its sampling", left_out,
          left_out ? probe.object.material + " is Lambertian: the lobe is 0"
                   : probe.object.material + " is glossy",
          left_out ? "a lobe for every VPL and every node of a cut, " + count_points(probe) : ""};
}

Omission plan_emission(const Probe& probe) {
  const bool lambertian = probe.request.emission == Emission::kLambertian;
  const bool left_out = lambertian || !has_gloss(probe.materials);
  return {"emission directions of VPLs", left_out,
          lambertian ? "VPLs emit by the diffuse part alone, as the study says"
          : left_out ? "every surface is diffuse, so that full emission is the diffuse part's"
                     : "some surface is glossy, and VPLs emit by all of its BRDF",
          left_out ? fmt::format("{} bytes a VPL, and a bound of every node", sizeof(VplGloss)) : ""};
}

Omission plan_direct(const Probe& probe) {
  const std::size_t lights = probe.world.spots().size() + probe.world.rectangles().size();
  const bool left_out = !probe.world.may_be_lit(0);
  return {"direct light of the object", left_out,
          left_out ? fmt::format("no cone of {} spots holds a part of its triangles, and no shining side of "
                                 "{} rectangles its box",
                                 probe.world.spots().size(), probe.world.rectangles().size())
                   : fmt::format("some of {} lights may reach it: what stands between is not asked",
                                 lights + (probe.world.environment() != Vec3{} ? 1 : 0)),
          left_out ? "its evaluation, " + count_points(probe) : ""};
}

std::string tell_saved_samples(const Probe& probe) {
  if (!probe.world.may_be_lit(0)) return "nothing more: none of the object is evaluated";
  return fmt::format("all but one of {} evaluations, {}", kBatches, count_points(probe));
}

Omission plan_direct_sampling(const Probe& probe) {
  const bool left_out = !has_extended_lights(probe.world);
  return {"sampling of direct light", left_out,
          left_out ? "no light has an area: its direct light is a sum, without chance"
                   : "a light has an area, or there is an environment",
          left_out ? tell_saved_samples(probe) : ""};
}

Omission plan_spots(const Probe& probe) {
  double asked = 0, points = 0;
  for (const PrimaryHit& hit : probe.primary.hits) {
    if (hit.kind == PrimaryKind::kNothing) continue;
    asked += static_cast<double>(probe.world.spots_at(hit.point.p).size());
    ++points;
  }
  const auto all = static_cast<double>(probe.world.spots().size());
  const double mean = points > 0 ? asked / points : all;
  const bool left_out = mean < all;
  return {
      "spots out of reach", left_out,
      left_out ? "the cone of such a spot misses the point's cell of a grid"
               : "no spot is out of reach of what the camera sees",
      left_out ? fmt::format("{:.1f} of {:.0f} spots at a point that the camera sees", all - mean, all) : ""};
}

Omission plan_tree(const Probe& probe) {
  const bool left_out = is_summed_plainly(probe.vpl_count());
  return {"the light tree", left_out,
          left_out ? "the sum over so few VPLs is exact, and all materials share its rays"
                   : fmt::format("cuts of {} VPLs are cheaper than their sum",
                                 format_vpl_count(probe.vpl_count())),
          left_out ? "the tree, cuts for each material, and the measuring of their error" : ""};
}

Omission plan_levels(const Probe& probe) {
  const std::size_t levels = probe.request.clamp_levels.size();
  return {"a traversal for each clamp level", levels > 1,
          levels > 1 ? "shadow rays and clusters serve all levels" : "one level is asked for",
          levels > 1 ? fmt::format("{} of {} traversals", levels - 1, levels) : ""};
}

Omission plan_shared_paths(const Probe& probe) {
  const std::size_t materials = probe.request.materials.size();
  if (materials < 2) return {"particles again for each material", false, "one material is asked for", ""};
  const VplSet vpls = trace_vpls(probe.world, probe.materials, kProbePaths, 1, "plan");
  return {"particles again for each material", true,
          "one that never met the object does not know its material",
          fmt::format("{:.0f} % of the particles of {} of {} materials",
                      100 - 100 * static_cast<double>(vpls.met.size()) / static_cast<double>(kProbePaths),
                      materials - 1, materials)};
}

Omission plan_backgrounds(const Probe& probe) {
  const std::size_t materials = probe.request.materials.size();
  return {"the background's paths again for each material", materials > 1,
          materials > 1 ? "one that never met the object does not know its material"
                        : "one material is asked for",
          materials > 1 ? fmt::format("of {} of {} materials what comes before a path meets the object",
                                      materials - 1, materials)
                        : ""};
}

Omission plan_views(const Probe& probe) {
  const bool of_study = !probe.request.materials.empty();
  return {"VPLs and trees again for each view", of_study,
          of_study ? "neither depends on the camera" : "one view is asked for",
          of_study ? fmt::format("{} of {} sets and trees", kViewCount - 1, kViewCount) : ""};
}

Omission plan_ray_length(const Probe& probe) {
  const bool left_out = !lacks_gloss(probe.request.emission, probe.materials);
  return {"long rays of compensation", left_out,
          left_out ? "beyond sqrt(M / c) nothing is clamped, and VPLs lack nothing"
                   : "Lambertian VPLs lack gloss at any distance",
          left_out ? "what lies beyond, if compensation is asked for" : ""};
}

Omission plan_reference(const Probe& probe) {
  const auto& method = probe.request.reference;
  const bool left_out = method == ReferenceMethod::kCompensated;
  return {"path tracing of the reference's indirect light", left_out,
          !method ? "a scene says nothing of references"
          : left_out
              ? "VPL sets and compensation have the same mean; where the pilots foresee that paths are "
                "cheaper, it is path traced all the same"
              : "the study asks for path tracing, or fixes its paths",
          left_out ? "what the reference's record tells against its path-traced check, for each object" : ""};
}

Omission plan_parts(const Probe& probe) {
  const Scene& scene = probe.scene;
  std::set<std::string> meshes = list_used_meshes(scene, scene.geometries.at(probe.object.geometry)),
                        materials{probe.object.material};
  for (const Instance& instance : scene.instances) {
    meshes.merge(list_used_meshes(scene, instance.mesh));
    materials.insert(instance.material);
  }
  for (const Sculpture& sculpture : scene.sculptures) {
    if (sculpture.name == probe.object.geometry) continue;
    meshes.merge(list_used_meshes(scene, scene.geometries.at(sculpture.name)));
    materials.insert(sculpture.material);
  }
  const std::size_t lights = probe.world.spots().size() + probe.world.rectangles().size() +
                             (probe.world.environment() != Vec3{} ? 1 : 0);
  const std::size_t no_mesh = probe.scene.meshes.size() - meshes.size(),
                    no_material = probe.scene.materials.size() - materials.size(),
                    no_light = probe.scene.lights.size() - lights;
  const bool left_out = no_mesh + no_material + no_light > 0;
  return {"meshes, materials and lights of other conditions", left_out,
          left_out ? "no instance names them, or they are off under this illumination" : "all are in use",
          left_out ? fmt::format("{} of {} meshes, {} of {} materials, {} of {} lights", no_mesh,
                                 probe.scene.meshes.size(), no_material, probe.scene.materials.size(),
                                 no_light, probe.scene.lights.size())
                   : ""};
}

Omission plan_disk(const Probe& probe) {
  const auto& layers = probe.request.layers_on_disk;
  if (!layers) return {"layers that are on disk", false, "no study folder was named", ""};
  return {
      "layers that are on disk", layers->first > 0,
      layers->first > 0
          ? "they were made from the same scene part, parameters and seed, and their bytes are those recorded"
          : "the folder has none that was made from this scene and study",
      layers->first > 0
          ? fmt::format("{} of {} layers of the condition and its reference", layers->first, layers->second)
          : ""};
}

}  // namespace

Plan make_plan(const Scene& scene, const PlanRequest& request) {
  const Probe probe(scene, request);
  Plan plan{request.source, format_key(request.condition), {}};
  for (const auto& omission : {plan_gloss, plan_emission, plan_direct, plan_direct_sampling, plan_spots,
                               plan_tree, plan_levels, plan_shared_paths, plan_backgrounds, plan_views,
                               plan_ray_length, plan_reference, plan_parts, plan_disk})
    plan.omissions.push_back(omission(probe));
  return plan;
}

std::string format_plan(const Plan& plan) {
  const auto left_out = std::count_if(plan.omissions.begin(), plan.omissions.end(),
                                      [](const Omission& omission) { return omission.left_out; });
  std::string text = fmt::format("{}, {}: {} of {} left out\n", plan.source, plan.condition, left_out,
                                 plan.omissions.size());
  for (const bool wanted : {true, false}) {
    for (const Omission& omission : plan.omissions) {
      if (omission.left_out != wanted) continue;
      text += fmt::format("\n{:<10}{}\n{:<10}because {}\n", wanted ? "left out" : "kept", omission.what, "",
                          omission.because);
      if (!omission.saves.empty()) text += fmt::format("{:<10}saves {}\n", "", omission.saves);
    }
  }
  return text;
}

}  // namespace equilux
