// Small scenes with known answers, written as files so that they take the same way as a user's.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "base/files.h"
#include "base/json.h"
#include "renderer/reference.h"
#include "stimuli/scene.h"

namespace equilux::test {

/// A folder of its own, removed at the end.
class Folder {
 public:
  Folder() {
    static std::atomic<int> next{0};
    path_ = std::filesystem::temp_directory_path() /
            ("equilux-" + std::to_string(::getpid()) + "-" + std::to_string(next++));
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Parts of a scene file as JSON text; what is left out is the least that is valid.
struct SceneText {
  std::string camera = R"({"position":[0,-4,0],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":40})";
  std::string materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]}])";
  std::string meshes = R"([{"name":"ball","sphere":{"radius":1,"subdivisions":5}}])";
  std::string instances = "[]";
  std::string lights =
      R"([{"spot":{"position":[0,-4,0],"target":[0,0,0],"inner_degrees":20,"outer_degrees":40,
                            "intensity":[1,1,1]}}])";
  std::string stand = "[0,0,-1]";
};

inline Scene make_scene(const SceneText& text) {
  const Folder folder;
  const auto path = folder / "scene.json";
  save_text(path, R"({"schema":"equilux-scene","schema_version":1,"name":"test","camera":)" + text.camera +
                      R"(,"materials":)" + text.materials + R"(,"meshes":)" + text.meshes +
                      R"(,"instances":)" + text.instances + R"(,"object":{"stand":)" + text.stand +
                      R"(,"geometries":[{"name":"G0","mesh":"ball"}]},"lights":)" + text.lights + "}");
  return load_scene(path);
}

/// A rough metal wall lights a grey ball: all the ball's light but the wall's diffuse part comes from gloss.
inline Scene make_metal_wall_scene() {
  SceneText text;
  text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]},
    {"name":"metal","model":"ward-duer","rho_d":[0.1,0.1,0.1],"rho_s":[0.3,0.3,0.3],"alpha":0.3}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":0.5,"subdivisions":5}},
    {"name":"wall","quad":{"u":[4,0,0],"v":[0,0,4]}}])";
  text.instances = R"([{"mesh":"wall","material":"metal","at":[-2,2,-2]}])";
  text.lights = R"([{"spot":{"position":[1.5,0,0],"target":[0.5,2,0],"inner_degrees":20,"outer_degrees":35,
      "intensity":[5,5,5]}}])";
  text.stand = "[0,0,-0.5]";
  text.camera = R"({"position":[3,0.5,0.3],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":25})";
  return make_scene(text);
}

inline double luminance_at(const HdrImage& image, std::size_t pixel) {
  const float* p = image.pixel(pixel);
  return luminance({p[0], p[1], p[2]});
}

inline FamilyProgress no_progress() {
  return {[](double) {}, [](double) {}};
}

/// Six rectangles of radiance 1 about the origin that shine inwards: a furnace of half side `h`.
inline std::string furnace_lights(double h) {
  const auto vec = [](double x, double y, double z) {
    return "[" + std::to_string(x) + "," + std::to_string(y) + "," + std::to_string(z) + "]";
  };
  const auto light = [&](const std::string& corner, const std::string& u, const std::string& v) {
    return R"({"rectangle":{"corner":)" + corner + R"(,"u":)" + u + R"(,"v":)" + v +
           R"(,"radiance":[1,1,1]}})";
  };
  const double s = 2 * h;
  return "[" + light(vec(-h, -h, -h), vec(s, 0, 0), vec(0, s, 0)) + "," +
         light(vec(-h, -h, h), vec(0, s, 0), vec(s, 0, 0)) + "," +
         light(vec(-h, -h, -h), vec(0, 0, s), vec(s, 0, 0)) + "," +
         light(vec(-h, h, -h), vec(s, 0, 0), vec(0, 0, s)) + "," +
         light(vec(-h, -h, -h), vec(0, s, 0), vec(0, 0, s)) + "," +
         light(vec(h, -h, -h), vec(0, 0, s), vec(0, s, 0)) + "]";
}

}  // namespace equilux::test
