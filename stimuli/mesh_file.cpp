// The one file that knows assimp.
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fstream>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "stimuli/mesh.h"

namespace equilux {
namespace {

Vec3 to_vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

bool is_degenerate(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Vec3 a = mesh.positions[triangle[0]];
  const Vec3 b = mesh.positions[triangle[1]];
  const Vec3 c = mesh.positions[triangle[2]];
  return !spans_area(b - a, c - a);
}

// A vertex of dropped triangles alone must not count in the mesh's box, nor as its lowest point.
TriangleMesh without_unused_vertices(const TriangleMesh& mesh) {
  constexpr auto kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> new_index(mesh.positions.size(), kUnused);
  TriangleMesh kept;
  for (auto triangle : mesh.triangles) {
    for (std::uint32_t& vertex : triangle) {
      if (new_index[vertex] == kUnused) {
        new_index[vertex] = static_cast<std::uint32_t>(kept.positions.size());
        kept.positions.push_back(mesh.positions[vertex]);
        kept.normals.push_back(mesh.normals[vertex]);
      }
      vertex = new_index[vertex];
    }
    kept.triangles.push_back(triangle);
  }
  return kept;
}

TriangleMesh to_mesh(const aiMesh& part, MeshRepairs& repairs) {
  TriangleMesh mesh;
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    mesh.positions.push_back(to_vec(part.mVertices[i]));
    mesh.normals.push_back(part.HasNormals() ? normalize(to_vec(part.mNormals[i])) : Vec3{});
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices != 3) {
      ++repairs.degenerate_triangles;
      continue;
    }
    const std::array<std::uint32_t, 3> triangle{face.mIndices[0], face.mIndices[1], face.mIndices[2]};
    if (is_degenerate(mesh, triangle)) {
      ++repairs.degenerate_triangles;
    } else {
      mesh.triangles.push_back(triangle);
    }
  }
  return repairs.degenerate_triangles > 0 ? without_unused_vertices(mesh) : mesh;
}

// What assimp's later steps take on trust: joining vertices merges a NaN with whatever it meets, and reads
// beyond the end for an index too large.
void check_part(const aiMesh& part, const std::string& source) {
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    if (!is_finite(to_vec(part.mVertices[i]))) {
      throw InputError(source, fmt::format("vertex {}", i), "finite coordinates", "NaN or infinity");
    }
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    for (unsigned j = 0; j < face.mNumIndices; ++j) {
      if (face.mIndices[j] < part.mNumVertices) continue;
      throw InputError(source, fmt::format("face {}", i), fmt::format("indices under {}", part.mNumVertices),
                       fmt::format("{}", face.mIndices[j]));
    }
  }
}

// assimp 5.2 reads a PLY header without an end for ever.
void check_ply_header(const std::filesystem::path& path) {
  constexpr std::size_t kMaxHeaderBytes = 1 << 16;
  std::string start(kMaxHeaderBytes, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(start.data(), kMaxHeaderBytes);
  start.resize(static_cast<std::size_t>(stream.gcount()));
  const bool is_ply = start.starts_with("ply") || start.starts_with("PLY");
  if (is_ply && start.find("end_header") == std::string::npos) {
    throw InputError(path.string(), "", "a PLY header that ends within 65,536 bytes", "none");
  }
}

}  // namespace

TriangleMesh load_mesh(const std::filesystem::path& path, MeshRepairs* repairs) {
  if (!is_file(path)) throw InputError(path.string(), "", "a mesh file", "no such file");
  check_ply_header(path);
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyFloat(AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, 80.0f);
  const aiScene* scene = importer.ReadFile(path.string(), 0);
  for (unsigned i = 0; scene && i < scene->mNumMeshes; ++i) check_part(*scene->mMeshes[i], path.string());
  if (scene) {
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_JoinIdenticalVertices |
                                         aiProcess_GenSmoothNormals | aiProcess_PreTransformVertices |
                                         aiProcess_SortByPType);
  }
  if (!scene) throw InputError(path.string(), "", "a mesh that assimp reads", importer.GetErrorString());
  TriangleMesh mesh;
  MeshRepairs found;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i) append_mesh(mesh, to_mesh(*scene->mMeshes[i], found));
  if (mesh.triangles.empty())
    throw InputError(path.string(), "", "at least one triangle of non-zero area", "none");
  if (repairs) *repairs = found;
  return mesh;
}

}  // namespace equilux
