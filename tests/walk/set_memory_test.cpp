// Memory of `set`: that of the largest world, however many there are.
// Side by side the six here take 3.7 times as much as one.
#include <gtest/gtest.h>

#include "base/files.h"
#include "base/json.h"
#include "tests/renderer/tiny_study.h"
#include "tests/walk/programs.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr int kGeometries = 6;

// A room with a choice of objects of 300,000 triangles.
Json make_scene_of_many() {
  const fs::path source = EQUILUX_SOURCE_DIR;
  Json scene = parse_json(load_text(source / "stimuli/scenes/proof-room.json"), "scene");
  Json meshes{Json::Array{}}, geometries{Json::Array{}};
  for (const Json& mesh : scene.at("meshes").as_array()) {
    if (mesh.find("quad")) meshes.push(mesh);
  }
  for (int i = 0; i < kGeometries; ++i) {
    const std::string name = "G" + std::to_string(i);
    const Json blob = Json()
                          .set("radius", 0.4)
                          .set("amplitude", 0.1)
                          .set("frequency", 3.0)
                          .set("seed", i)
                          .set("subdivisions", 7);
    meshes.push(Json().set("name", name).set("blob", blob));
    geometries.push(Json().set("name", name).set("mesh", name));
  }
  Json object = scene.at("object");
  return scene.set("meshes", meshes).set("object", object.set("geometries", geometries));
}

// The rows of G0 for every geometry.
void multiply_rows(const fs::path& path, const std::string& member) {
  Json json = parse_json(load_text(path), path.string()), rows{Json::Array{}};
  for (const Json& row : json.at(member).as_array()) {
    for (int i = 0; i < kGeometries; ++i) {
      Json other = row;
      rows.push(other.set("column", "G" + std::to_string(i) + row.at("column").as_string().substr(2)));
    }
  }
  save_text(path, format_json(json.set(member, rows)));
}

void choose_among_many(const test::TinyStudy& study) {
  save_text(study.folder() / "scene.json", format_json(make_scene_of_many()));
  Json geometries{Json::Array{}}, json = parse_json(load_text(study.path()), "study");
  for (int i = 0; i < kGeometries; ++i) geometries.push("G" + std::to_string(i));
  Json block = json.at("blocks").at(std::size_t{0});
  json.set("scene", "scene.json").set("blocks", Json(Json::Array{block.set("geometries", geometries)}));
  save_text(study.path(), format_json(json));
  multiply_rows(study.folder() / "windows.json", "windows");
  multiply_rows(study.folder() / "truth.json", "columns");
}

TEST(SetMemory, GoesWithTheLargestWorldNotWithTheirNumber) {
  const test::TinyStudy study("normalise");
  choose_among_many(study);
  const auto measure = [&](const std::string& only) {
    const fs::path folder = study.folder() / "set";
    run_well("render", {"set", study.path(), "--out", folder, "--only", only, "--threads", "2"});
    const Json timing = parse_json(load_text(folder / "timing.json"), "timing");
    const double peak = timing.at("runs").as_array().back().at("peak_memory_bytes").as_double();
    fs::remove_all(folder);
    return peak / (1 << 20);
  };
  const double one = measure("G0-*-ref-v0"), all = measure("G?-*-ref-v0");
  EXPECT_LT(all, 2.5 * one) << "MiB, of " << kGeometries << " geometries and of one";
}

}  // namespace
}  // namespace equilux
