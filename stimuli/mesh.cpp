// What every mesh needs, wherever it came from.
#include "stimuli/mesh.h"

#include <string_view>

#include "base/digest.h"

namespace equilux {
namespace {

// A mesh in which each triangle has vertices of its own, with the face's normal.
TriangleMesh with_flat_normals(const TriangleMesh& mesh) {
  TriangleMesh flat;
  for (const auto& triangle : mesh.triangles) {
    const Vec3 a = mesh.positions[triangle[0]];
    const Vec3 b = mesh.positions[triangle[1]];
    const Vec3 c = mesh.positions[triangle[2]];
    const auto first = static_cast<std::uint32_t>(flat.positions.size());
    flat.positions.insert(flat.positions.end(), {a, b, c});
    flat.normals.insert(flat.normals.end(), 3, normalize(cross(b - a, c - a)));
    flat.triangles.push_back({first, first + 1, first + 2});
  }
  return flat;
}

}  // namespace

std::string digest_mesh(const TriangleMesh& mesh) {
  const auto bytes = [](const auto& values) {
    return std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0]));
  };
  return digest_text(digest_text(bytes(mesh.positions)) + digest_text(bytes(mesh.normals)) +
                     digest_text(bytes(mesh.triangles)));
}

void append_mesh(TriangleMesh& a, const TriangleMesh& b) {
  if (b.triangles.empty()) return;
  if (a.triangles.empty()) {
    a = b;
    return;
  }
  if (a.normals.empty() != b.normals.empty()) {
    if (a.normals.empty()) a = with_flat_normals(a);
    if (b.normals.empty()) return append_mesh(a, with_flat_normals(b));
  }
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  a.normals.insert(a.normals.end(), b.normals.begin(), b.normals.end());
  for (const auto& triangle : b.triangles) {
    a.triangles.push_back({triangle[0] + offset, triangle[1] + offset, triangle[2] + offset});
  }
}

}  // namespace equilux
