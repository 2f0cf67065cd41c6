// A mesh file: the first byte chooses the ending of its name, which says the format; one that names none
// leaves it to what the file holds.
#include "stimuli/mesh.h"

#include "tests/fuzz/fuzz.h"

namespace {

void check_mesh(const equilux::TriangleMesh& mesh) {
  using namespace equilux;
  EQ_CHECK(mesh.normals.size() == mesh.positions.size(), mesh.normals.size(), mesh.positions.size());
  for (Vec3 p : mesh.positions) EQ_CHECK(is_finite(p), p.x, p.y, p.z);
  for (Vec3 n : mesh.normals) EQ_CHECK(is_finite(n), n.x, n.y, n.z);
  for (const auto& triangle : mesh.triangles) {
    for (std::uint32_t vertex : triangle) EQ_CHECK(vertex < mesh.positions.size(), vertex);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  if (size == 0) return 0;
  constexpr const char* kNames[] = {"input.obj", "input.ply", "input.stl", "input.mesh"};
  const auto path = fuzz_folder().write(kNames[bytes[0] % 4], as_text(bytes + 1, size - 1));
  expect_read_or_refused(path.filename().string(), [&] { check_mesh(load_mesh(path)); });
  return 0;
}
