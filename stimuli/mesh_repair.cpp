// What is mended in a mesh from a file: which vertices are one, which triangles go, how normals are smoothed.
#include <map>
#include <numeric>
#include <set>

#include "base/error.h"
#include "stimuli/mesh.h"

namespace equilux {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Of triangles that meet in a point, of all points together: every pair is looked at.
constexpr std::size_t kMaxPairs = 400'000'000;
constexpr std::size_t kUsualPairs = 100;  // a triangle: of six round each point there are 18
constexpr float kCosCrease = 0.173648f;   // of 80 degrees

/// One place of the mesh, however many vertices stand there.
struct Welded {
  std::vector<Vec3> points;
  std::vector<std::uint32_t> point_of;  ///< of each vertex
};

Welded weld_vertices(const std::vector<Vec3>& positions) {
  Welded welded;
  std::map<std::array<float, 3>, std::uint32_t> known;
  for (Vec3 p : positions) {
    const auto next = static_cast<std::uint32_t>(welded.points.size());
    const auto [found, added] = known.try_emplace({p.x, p.y, p.z}, next);
    if (added) welded.points.push_back(p);
    welded.point_of.push_back(found->second);
  }
  return welded;
}

/// A triangle that is kept: its places and its vertices in the file.
struct Face {
  Triangle points, vertices;
  Vec3 normal;
};

Face make_face(const Welded& welded, const Triangle& vertices) {
  Face face{{}, vertices, {}};
  for (std::size_t i = 0; i < 3; ++i) face.points[i] = welded.point_of[vertices[i]];
  const Vec3 a = welded.points[face.points[0]];
  const Vec3 u = normalize(welded.points[face.points[1]] - a);
  const Vec3 v = normalize(welded.points[face.points[2]] - a);
  if (spans_area(u, v)) face.normal = normalize(cross(u, v));
  return face;
}

std::vector<Face> keep_faces(const Welded& welded, const std::vector<Triangle>& triangles,
                             MeshRepairs& repairs) {
  std::vector<Face> faces;
  std::set<Triangle> known;
  for (const Triangle& triangle : triangles) {
    const Face face = make_face(welded, triangle);
    Triangle sorted = face.points;
    std::sort(sorted.begin(), sorted.end());
    if (face.normal == Vec3{}) {
      ++repairs.degenerate_triangles;
    } else if (!known.insert(sorted).second) {
      ++repairs.duplicate_triangles;
    } else {
      faces.push_back(face);
    }
  }
  return faces;
}

void count_edges(const std::vector<Face>& faces, MeshRepairs& repairs) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const Face& face : faces) {
    for (std::size_t i = 0; i < 3; ++i)
      edges.push_back(std::minmax({face.points[i], face.points[(i + 1) % 3]}));
  }
  std::sort(edges.begin(), edges.end());
  for (auto first = edges.begin(); first != edges.end();) {
    const auto end = std::upper_bound(first, edges.end(), *first);
    repairs.open_edges += end - first == 1;
    repairs.non_manifold_edges += end - first > 2;
    first = end;
  }
}

/// One corner of a face, and which of its point's fans it belongs to. units: radians
struct Corner {
  std::size_t face, slot;
  float angle = 0;
  std::size_t fan = 0;
};

float corner_angle(const std::vector<Vec3>& points, const Face& face, std::size_t slot) {
  const Vec3 p = points[face.points[slot]];
  const Vec3 u = normalize(points[face.points[(slot + 1) % 3]] - p);
  const Vec3 v = normalize(points[face.points[(slot + 2) % 3]] - p);
  return std::atan2(length(cross(u, v)), dot(u, v));
}

std::vector<std::vector<Corner>> gather_corners(const std::vector<Face>& faces,
                                                const std::vector<Vec3>& points) {
  std::vector<std::vector<Corner>> corners(points.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (std::size_t slot = 0; slot < 3; ++slot)
      corners[faces[i].points[slot]].push_back({i, slot, corner_angle(points, faces[i], slot)});
  }
  return corners;
}

std::size_t find_root(std::vector<std::size_t>& parents, std::size_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

// Corners of one point that share an edge there are of one fan, named by one of them. Gives the number of
// fans.
std::size_t assign_fans(const std::vector<Face>& faces, std::vector<Corner>& corners) {
  std::vector<std::size_t> parents(corners.size());
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  std::map<std::uint32_t, std::size_t> first_at;  // the edge to this point
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t step : {1, 2}) {
      const std::uint32_t other = faces[corners[i].face].points[(corners[i].slot + step) % 3];
      const std::size_t first = first_at.try_emplace(other, i).first->second;
      parents[find_root(parents, i)] = find_root(parents, first);
    }
  }
  std::set<std::size_t> fans;
  for (std::size_t i = 0; i < corners.size(); ++i) fans.insert(corners[i].fan = find_root(parents, i));
  return fans.size();
}

// All its terms are on one side of the face, so they cannot cancel. `normals`: of the corners' faces.
Vec3 smooth_normal(const std::vector<Vec3>& normals, const std::vector<Corner>& corners, std::size_t corner) {
  const Vec3 own = normals[corner];
  Vec3 sum;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i].fan == corners[corner].fan && dot(own, normals[i]) >= kCosCrease)
      sum += normals[i] * corners[i].angle;
  }
  return sum == Vec3{} ? own : normalize(sum);
}

// Vertices of one point: as many as it has fans and normals.
void add_point(TriangleMesh& mesh, const Welded& welded, const std::vector<Face>& faces,
               const std::vector<Corner>& corners, const std::vector<Vec3>& file_normals) {
  std::map<std::pair<std::size_t, std::array<float, 3>>, std::uint32_t> known;
  std::vector<Vec3> normals;
  for (const Corner& corner : corners) normals.push_back(faces[corner.face].normal);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Corner& corner = corners[i];
    const Face& face = faces[corner.face];
    Vec3 normal = file_normals.empty() ? Vec3{} : file_normals[face.vertices[corner.slot]];
    if (normal == Vec3{}) normal = smooth_normal(normals, corners, i);
    const auto next = static_cast<std::uint32_t>(mesh.positions.size());
    const auto [found, added] = known.try_emplace({corner.fan, {normal.x, normal.y, normal.z}}, next);
    if (added) {
      mesh.positions.push_back(welded.points[face.points[corner.slot]]);
      mesh.normals.push_back(normal);
    }
    mesh.triangles[corner.face][corner.slot] = found->second;
  }
}

}  // namespace

TriangleMesh repair_mesh(const TriangleMesh& mesh, MeshRepairs& repairs, const std::string& source) {
  const Welded welded = weld_vertices(mesh.positions);
  repairs.duplicate_vertices += mesh.positions.size() - welded.points.size();
  const std::vector<Face> faces = keep_faces(welded, mesh.triangles, repairs);
  count_edges(faces, repairs);
  TriangleMesh repaired;
  repaired.triangles.resize(faces.size());
  std::vector<std::vector<Corner>> by_point = gather_corners(faces, welded.points);
  std::size_t pairs = 0;
  for (const std::vector<Corner>& corners : by_point) pairs += corners.size() * corners.size();
  if (pairs > std::max(kMaxPairs, kUsualPairs * faces.size())) {
    throw InputError(source, "", fmt::format("at most {} pairs of triangles that meet in a point", kMaxPairs),
                     fmt::format("{}", pairs));
  }
  for (std::vector<Corner>& corners : by_point) {
    repairs.non_manifold_vertices += assign_fans(faces, corners) > 1;
    add_point(repaired, welded, faces, corners, mesh.normals);
  }
  return repaired;
}

}  // namespace equilux
