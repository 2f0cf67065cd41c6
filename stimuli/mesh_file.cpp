// The one file that knows assimp.
#include <algorithm>
#include <assimp/BaseImporter.h>
#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "base/error.h"
#include "base/files.h"
#include "stimuli/mesh.h"
#include "stimuli/obj_file.h"
#include "stimuli/ply_check.h"

namespace equilux {
namespace {

Vec3 to_vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Vec3 to_normal(const aiVector3D& v) { return is_finite(to_vec(v)) ? normalize(to_vec(v)) : Vec3{}; }

TriangleMesh to_mesh(const aiMesh& part, bool with_normals, MeshRepairs& repairs) {
  TriangleMesh mesh;
  with_normals = with_normals && part.HasNormals();
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    mesh.positions.push_back(to_vec(part.mVertices[i]));
    mesh.normals.push_back(with_normals ? to_normal(part.mNormals[i]) : Vec3{});
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices == 3) {
      mesh.triangles.push_back({face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    } else {
      ++repairs.degenerate_triangles;
    }
  }
  return mesh;
}

// What assimp's later steps and ours take on trust.
void check_part(const aiMesh& part, const std::string& source) {
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    if (!is_finite(to_vec(part.mVertices[i]))) {
      throw InputError(source, fmt::format("vertex {}", i), "finite coordinates", "NaN or infinity");
    }
  }
  for (unsigned i = 0; i < part.mNumFaces; ++i) {
    const aiFace& face = part.mFaces[i];
    if (face.mNumIndices == 0)
      throw InputError(source, fmt::format("face {}", i), "at least one corner", "none");
    for (unsigned j = 0; j < face.mNumIndices; ++j) {
      if (face.mIndices[j] < part.mNumVertices) continue;
      throw InputError(source, fmt::format("face {}", i), fmt::format("indices under {}", part.mNumVertices),
                       fmt::format("{}", face.mIndices[j]));
    }
  }
}

// PLY and STL have no further files, and theirs is in memory.
class NoFiles : public Assimp::DefaultIOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
};

// The one format that the file is taken for: assimp looks for the beginning of a PLY in all of a file, and
// those of whole scenes nest and refer, so that it follows a few bytes of theirs until stack or memory end.
void forget_other_formats(Assimp::Importer& importer, std::string_view format) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    if (importer.GetImporterInfo(i)->mFileExtensions != format) others.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;  // it is the caller's then
  }
}

// Twenty million triangles as PLY.
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;

// Without the name that assimp gives to memory.
std::string tell_error(const Assimp::Importer& importer, const std::string& source) {
  std::string error = importer.GetErrorString();
  const std::size_t start = error.find("$$$");
  if (start == std::string::npos) return error;
  const std::size_t end = std::min(error.find_first_of(" \"", start), error.size());
  return error.replace(start, end - start, std::filesystem::path(source).filename().string());
}

TriangleMesh read_by_assimp(const std::filesystem::path& path, const std::string& bytes, MeshRepairs& found) {
  const bool is_ply = check_ply(path.string(), bytes);
  if (!is_ply && has_extension(path, ".ply"))
    throw InputError(path.string(), "", "a PLY file, which begins with ply", "another beginning");
  Assimp::Importer importer;
  const char* format = is_ply ? "ply" : "stl";
  forget_other_formats(importer, format);
  importer.SetIOHandler(new NoFiles);  // which it deletes
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), 0, format);
  for (unsigned i = 0; scene && i < scene->mNumMeshes; ++i) check_part(*scene->mMeshes[i], path.string());
  if (scene) {
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate | aiProcess_PreTransformVertices |
                                         aiProcess_SortByPType);
  }
  if (!scene)
    throw InputError(path.string(), "", "a mesh in OBJ, PLY or STL", tell_error(importer, path.string()));
  TriangleMesh parts;
  for (unsigned i = 0; i < scene->mNumMeshes; ++i)
    append_mesh(parts, to_mesh(*scene->mMeshes[i], is_ply, found));
  return parts;
}

// Each corner of an OBJ has a vertex of its own, so those of the file are counted as it is read.
TriangleMesh read_and_repair_obj(const std::string& source, const std::string& text, MeshRepairs& found) {
  const TriangleMesh parts = read_obj(source, text, found);
  const std::size_t duplicates = found.duplicate_vertices;
  TriangleMesh mesh = repair_mesh(parts, found, source);
  found.duplicate_vertices = duplicates;
  return mesh;
}

}  // namespace

TriangleMesh load_mesh(const std::filesystem::path& path, MeshRepairs* repairs) {
  const std::string bytes = load_text(path, kMaxFileBytes);
  MeshRepairs ignored;
  MeshRepairs& found = repairs ? *repairs : ignored;
  TriangleMesh mesh = is_obj(path, bytes)
                          ? read_and_repair_obj(path.string(), bytes, found)
                          : repair_mesh(read_by_assimp(path, bytes, found), found, path.string());
  if (mesh.triangles.empty())
    throw InputError(path.string(), "", "at least one triangle of non-zero area", "none");
  return mesh;
}

}  // namespace equilux
