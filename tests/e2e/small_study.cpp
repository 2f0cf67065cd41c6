// Every file is written by the library that the programs use.
#include "tests/e2e/small_study.h"

#include "base/digest.h"
#include "base/files.h"
#include "base/json.h"
#include "base/random.h"
#include "stimuli/manifest.h"
#include "stimuli/png_file.h"
#include "tests/experiment/fake_study.h"

namespace equilux {
namespace {

constexpr const char* kStudy = R"({
  "schema": "equilux-study", "schema_version": 1, "name": "small",
  "scene": "scene.json", "windows": "windows.json", "truth": "truth.json", "seed": 7,
  "image": {"width": 1, "height": 1}, "subpixel_positions": 1,
  "paths": {"object_indirect": 1, "object_direct": 1, "background": 1},
  "noise_target": {"object_mean": 1, "object_p99": 3, "outside_mean": 2},
  "exposure": "background", "tone_key": 0.18, "clamp_levels": ["C3", "C4", "C5", "C6", "C7"],
  "normalise": false, "view_mode": "reference_turned",
  "target": {"degrees_wide": 16, "degrees_high": 12, "viewing_distance_m": 0.4572},
  "subjects": {"artifact": 12, "material": 14},
  "blocks": [{"geometries": ["G0"], "materials": ["MS", "GS"], "illuminations": ["ind"], "vpl_counts": ["1k"]}]
})";

constexpr const char* kWindows = R"({
  "schema": "equilux-windows", "schema_version": 1,
  "windows": [
    {"column": "G0-MS-ind-1k", "first": "C4", "origin": "by_eye"},
    {"column": "G0-GS-ind-1k", "first": "C3", "origin": "by_eye"}
  ]
})";

// A tint, a gradient and noise, all of the key's own.
LdrImage make_picture(const std::string& key, int width, int height) {
  LdrImage image(width, height);
  RandomStream random(1, key, 0);
  const std::uint32_t tint = random.next_u32();
  std::size_t at = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint32_t noise = random.next_u32();
      for (unsigned channel = 0; channel < 3; ++channel) {
        const unsigned base = (tint >> (8 * channel)) & 127U;
        const auto slope = static_cast<unsigned>(64 * x / width + 32 * y / height);
        image.values[at++] = static_cast<std::uint8_t>(base + slope + ((noise >> (8 * channel)) & 31U));
      }
    }
  }
  return image;
}

void add_picture(Manifest& manifest, const StudyFolder& folder, const std::string& key) {
  const std::string file = "pictures/" + key + ".png";
  save_png(make_picture(key, manifest.width, manifest.height), folder.root / file);
  manifest.pictures[key] = {file, digest_file(folder.root / file), digest_text(key), Json()};
}

void save_small_manifest(const StudyFolder& folder, const Study& study) {
  Manifest manifest;
  manifest.study_name = study.name;
  manifest.study_digest = study.digest;
  manifest.seed = study.seed;
  manifest.width = study.width;
  manifest.height = study.height;
  for (const Condition& condition : enumerate_conditions(study)) {
    add_picture(manifest, folder, format_key(condition));
  }
  for (const Family& family : enumerate_references(study)) {
    const std::string key = format_key(family);
    add_picture(manifest, folder, key);
    manifest.pictures[key].standard_error =
        Json().set("object_mean", 0.1).set("object_p99", 0.2).set("outside_mean", 0.1);
    manifest.tones[key] = {0.1, 1.0, 1e-7, study.tone.key, "background"};
  }
  save_manifest(manifest, folder.manifest());
}

}  // namespace

StudyFolder make_small_study(const std::filesystem::path& root, int width, int height) {
  const StudyFolder folder{root};
  make_folder(folder.picture_folder());
  Json study = parse_json(kStudy, "small study");
  study.set("image", Json().set("width", width).set("height", height));
  save_text(folder.study(), format_json(study));
  save_text(folder.windows(), kWindows);
  const Study loaded = load_folder_study(folder);
  save_small_manifest(folder, loaded);
  save_fake_selection(folder, SubjectKind::kPerson, {5, 7});
  return folder;
}

LdrImage load_small_picture(const StudyFolder& folder, const std::string& key) {
  return load_png(folder.root / "pictures" / (key + ".png"));
}

}  // namespace equilux
