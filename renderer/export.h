// The diffuse version of a scene for another renderer: a Python script that builds and renders it in Blender.
#pragma once

#include <string>
#include <vector>

#include "stimuli/scene.h"

namespace equilux {

struct ExportParams {
  Object object;
  int view = 0;
  int width = 560;
  int height = 420;
};

/// What the script builds: only what this object, illumination and view need, every surface Lambertian.
struct DiffuseScene {
  struct Mesh {
    std::string name;
    TriangleMesh mesh;
  };
  struct Surface {
    std::size_t mesh = 0, material = 0;  ///< indices
    Placement placement;
  };
  std::string title;  ///< scene, object and view in words
  Camera camera;
  int width = 0, height = 0;
  std::vector<Mesh> meshes;             ///< each once; the first is the object's, in its place
  std::vector<MaterialSpec> materials;  ///< each once, the object's first; only rho_d counts
  std::vector<Surface> surfaces;        ///< the first is the object
  std::vector<SpotLight> spots;
  std::vector<RectangleLight> rectangles;
  Vec3 environment;  ///< black without one. units: W/(m^2 sr)
};

/// errors: InputError for a geometry or material that the scene lacks, or a mesh that cannot be read.
DiffuseScene make_diffuse_scene(const Scene& scene, const ExportParams& params);

/// Names of the materials that lose a glossy part.
std::vector<std::string> find_glossy_materials(const DiffuseScene& scene);

/// Triangles of all surfaces; those of rectangle lights do not count.
std::size_t count_triangles(const DiffuseScene& scene);

/// For Blender 3.4 and its renderer Cycles; the text says how to call it. The same scene gives the same text;
/// numbers keep their shortest exact form.
std::string format_blender_script(const DiffuseScene& scene);

}  // namespace equilux
