// The one file that knows assimp.
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "base/error.h"
#include "stimuli/mesh.h"

namespace equilux {
namespace {

Vec3 to_vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

bool is_degenerate(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Vec3 a = mesh.positions[triangle[0]];
  const Vec3 b = mesh.positions[triangle[1]];
  const Vec3 c = mesh.positions[triangle[2]];
  return cross(b - a, c - a) == Vec3{};
}

TriangleMesh to_mesh(const aiMesh& part, MeshRepairs& repairs, const std::string& source) {
  TriangleMesh mesh;
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    mesh.positions.push_back(to_vec(part.mVertices[i]));
    mesh.normals.push_back(part.HasNormals() ? normalize(to_vec(part.mNormals[i])) : Vec3{});
    if (!is_finite(mesh.positions.back())) {
      throw InputError(source, fmt::format("vertex {}", i), "finite coordinates", "NaN or infinity");
    }
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) {
      ++repairs.degenerate_triangles;
      continue;
    }
    const std::array<std::uint32_t, 3> triangle{face.mIndices[0], face.mIndices[1], face.mIndices[2]};
    for (std::uint32_t index : triangle) {
      if (index >= part.mNumVertices) {
        throw InputError(source, fmt::format("face {}", i),
                         fmt::format("indices under {}", part.mNumVertices), fmt::format("{}", index));
      }
    }
    if (is_degenerate(mesh, triangle)) {
      ++repairs.degenerate_triangles;
    } else {
      mesh.triangles.push_back(triangle);
    }
  }
  return mesh;
}

}  // namespace

TriangleMesh load_mesh(const std::filesystem::path& path, MeshRepairs* repairs) {
  if (!std::filesystem::is_regular_file(path))
    throw InputError(path.string(), "", "a mesh file", "no such file");
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 80.0f);
  const aiScene* scene = importer.ReadFile(
      path.string(), aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals |
                         aiProcess_PreTransformVertices | aiProcess_SortByPType);
  if (!scene) throw InputError(path.string(), "", "a mesh that assimp reads", importer.GetErrorString());
  TriangleMesh mesh;
  MeshRepairs found;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    append_mesh(mesh, to_mesh(*scene->mMeshes[i], found, path.string()));
  if (mesh.triangles.empty())
    throw InputError(path.string(), "", "at least one triangle of non-zero area", "none");
  if (repairs) *repairs = found;
  return mesh;
}

}  // namespace equilux
