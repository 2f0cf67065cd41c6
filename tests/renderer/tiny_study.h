// A study of the real café, or of one sculpture of the gallery, that renders in seconds: 24 x 18 pixels, 100
// VPLs, one geometry.
#pragma once

#include <map>

#include "base/digest.h"
#include "protocols/study.h"
#include "tests/renderer/test_scene.h"

namespace equilux::test {

/// Of every file of a study folder but those that tell of times. shape: relative name -> digest
inline std::map<std::string, std::string> digest_products(const std::filesystem::path& folder) {
  std::map<std::string, std::string> digests;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    if (!entry.is_regular_file() || name == "timing.json" || name == "render.log") continue;
    digests[std::filesystem::relative(entry.path(), folder).string()] = digest_file(entry.path());
  }
  return digests;
}

class TinyStudy {
 public:
  explicit TinyStudy(const std::string& variant = "") : folder_(own_.path()) { write(variant, 1); }
  /// Another study file in the folder of an existing one.
  TinyStudy(const std::filesystem::path& folder, std::uint64_t seed) : folder_(folder) { write("", seed); }

  const std::filesystem::path& folder() const { return folder_; }
  const std::filesystem::path& path() const { return path_; }
  Study load() const { return load_study(path_); }

 private:
  void write(const std::string& variant, std::uint64_t seed) {
    const bool normalise = variant.starts_with("normalise"), many = variant.ends_with("many"),
               compensated = variant.starts_with("compensated"), one_light = normalise || compensated,
               gallery = variant == "gallery";
    const std::string count = many ? "30k" : "100";
    const std::string geometry = gallery ? "Knot" : "G0";
    const std::filesystem::path source = EQUILUX_SOURCE_DIR;
    Json json = parse_json(load_text(source / "protocols/pocket.json"), "pocket");
    json.set("scene", (source / "stimuli/scenes" / (gallery ? "gallery.json" : "cafe.json")).string())
        .set("seed", seed);
    json.set("image", parse_json(R"({"width":24,"height":18})", "")).set("subpixel_positions", 2);
    if (compensated) {
      const bool room = variant == "compensated-room";  // that is worth keeping
      json.set("image", parse_json(R"({"width":48,"height":36})", ""));
      json.set("noise_target", Json()
                                   .set("object_mean", room ? 6.0 : 3.0)
                                   .set("object_p99", room ? 18.0 : 9.0)
                                   .set("outside_mean", room ? 3.0 : 60.0));
    } else {
      json.set("reference", "path");
      json.set("paths", parse_json(R"({"object_indirect":32,"object_direct":32,"background":32})", ""));
    }
    json.set("normalise", normalise).set("windows", "windows.json").set("truth", "truth.json");
    json.set("session", "session.json");
    const std::vector<std::string> names =
        compensated && many ? std::vector<std::string>{"BR", "GS"} : std::vector<std::string>{"MS", "GS"};
    const std::string materials = compensated && many ? R"(["BR","GS"])" : R"(["MS","GS"])";
    const std::string illuminations = one_light ? R"(["ind"])" : R"(["ind","dir"])";
    json.set("blocks", parse_json(R"([{"geometries":[")" + geometry + R"("],"materials":)" + materials +
                                      R"(,"illuminations":)" + illuminations + R"(,"vpl_counts":[")" + count +
                                      R"("]}])",
                                  ""));
    path_ = folder_ / ("study-" + variant + std::to_string(seed) + ".json");
    Json windows{Json::Array{}}, truth{Json::Array{}};
    for (const std::string illumination : {"ind", "dir"}) {
      if (one_light && illumination == "dir") continue;
      for (const std::string& material : names) {
        const std::string column = geometry + "-" + material + "-" + illumination + "-" + count;
        windows.push(Json().set("column", column).set("first", "C2").set("origin", "placeholder"));
        truth.push(
            Json().set("column", column).set("artifact_free_from", "C4").set("material_same_to", "C6"));
      }
    }
    save_text(path_, format_json(json));
    save_text(folder_ / "session.json",
              format_json(Json().set("schema", "equilux-session").set("schema_version", 1)));
    save_text(folder_ / "windows.json",
              format_json(
                  Json().set("schema", "equilux-windows").set("schema_version", 1).set("windows", windows)));
    save_text(folder_ / "truth.json", format_json(Json()
                                                      .set("schema", "equilux-truth")
                                                      .set("schema_version", 1)
                                                      .set("lapse_rate", 0.02)
                                                      .set("side_bias", 0.5)
                                                      .set("columns", truth)));
  }

  Folder own_;
  std::filesystem::path folder_;
  std::filesystem::path path_;
};

}  // namespace equilux::test
