// Study folders without a renderer: true study files, a whole manifest, and pictures of a few pixels.
#pragma once

#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <string>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "experiment/trial_log.h"
#include "stimuli/manifest.h"
#include "stimuli/png_file.h"
#include "stimuli/selection.h"
#include "stimuli/study_folder.h"
#include "tests/support/temp_folder.h"

namespace equilux {

/// A new folder in memory where there is /dev/shm, removed at the end of its scope.
class TemporaryFolder : public TempFolder {
 public:
  TemporaryFolder() : TempFolder(find_memory_folder()) {}
};

inline std::filesystem::path protocol_path(const std::string& name) {
  return std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols" / (name + ".json");
}

/// The four studies that Equilux brings along.
inline Study load_protocol(const std::string& name) { return load_study(protocol_path(name)); }

/// A picture of one colour, which is a function of its key: no two files are alike.
inline LdrImage make_fake_picture(const std::string& key, int width, int height) {
  const std::string digest = digest_text(key);
  LdrImage image(width, height);
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    image.values[i] = static_cast<std::uint8_t>(digest[i % 3] + 3 * digest[i % 3 + 3]);
  }
  return image;
}

/// Writes the picture and gives its record, as a renderer would.
inline PictureRecord save_fake_picture(const StudyFolder& folder, const std::string& key, int width,
                                       int height) {
  const std::string file = "pictures/" + key + ".png";
  save_png(make_fake_picture(key, width, height), folder.root / file);
  return {file, digest_file(folder.root / file), digest_text("layers of " + key), Json()};
}

/// A study that names no session protocol: its folder needs no session.json.
inline Json without_session(const Json& study) {
  Json rest{Json::Object{}};
  for (const auto& [member, value] : study.as_object()) {
    if (member != "session") rest.set(member, value);
  }
  return rest;
}

/// Makes `root` a study folder of a protocol: study.json, windows.json, truth.json, manifest.json and all
/// pictures. Nothing of it was rendered.
inline StudyFolder make_fake_study(const std::filesystem::path& root, const std::string& protocol = "pocket",
                                   int width = 4, int height = 3) {
  namespace fs = std::filesystem;
  const StudyFolder folder{root};
  make_folder(folder.picture_folder());
  Json json = without_session(load_study(protocol_path(protocol)).source);
  json.set("image", Json().set("width", width).set("height", height));
  save_text(folder.study(), format_json(json));
  fs::copy_file(protocol_path(protocol).replace_extension() / "windows.json", folder.windows());
  fs::copy_file(protocol_path(protocol).replace_extension() / "truth.json", folder.truth());
  const Study study = load_folder_study(folder);
  Manifest manifest{study.name, study.digest, study.seed, width, height, {}, {}};
  for (const Condition& condition : enumerate_conditions(study)) {
    const std::string key = format_key(condition);
    manifest.pictures[key] = save_fake_picture(folder, key, width, height);
  }
  for (const Family& family : enumerate_references(study)) {
    const std::string key = format_key(family);
    manifest.pictures[key] = save_fake_picture(folder, key, width, height);
    manifest.pictures[key].standard_error =
        Json().set("object_mean", 0.5).set("object_p99", 1.5).set("outside_mean", 0.5);
    manifest.tones[key] = {0.1, 1.0, 1e-7, study.tone.key, "background"};
  }
  save_manifest(manifest, folder.manifest());
  return folder;
}

/// Writes a truth in which every column has the same thresholds.
inline void save_fake_truth(const StudyFolder& folder, double lapse_rate, double side_bias,
                            const std::string& artifact_free_from, const std::string& material_same_to,
                            const std::filesystem::path& path) {
  Json columns{Json::Array{}};
  for (const Column& column : enumerate_columns(load_folder_study(folder))) {
    Json row;
    row.set("column", format_key(column)).set("artifact_free_from", artifact_free_from);
    row.set("material_same_to", material_same_to);
    columns.push(std::move(row));
  }
  Json truth;
  truth.set("schema", "equilux-truth").set("schema_version", 1);
  truth.set("lapse_rate", lapse_rate).set("side_bias", side_bias).set("columns", std::move(columns));
  save_text(path, format_json(truth));
}

/// Writes selection-<kind>.json with these levels in every column, of the artifact answers that are in the
/// log now (none, where there is no log): what pruning leaves behind, without its rules.
inline Selection save_fake_selection(const StudyFolder& folder, SubjectKind kind,
                                     const std::vector<int>& levels) {
  const Study study = load_folder_study(folder);
  Selection selection{kind, "paper", study.digest, digest_answers({}), {}};
  if (std::filesystem::exists(folder.responses())) {
    selection.answers_digest =
        digest_answers(TrialLog(folder.responses()).load_answers(kind, Experiment::kArtifact));
  }
  for (const Column& column : enumerate_columns(study)) {
    selection.columns.push_back({column, levels.empty() ? "none" : "cut",
                                 levels.empty() ? std::nullopt : std::optional(levels.front()), levels});
  }
  save_selection(selection, folder.selection(kind));
  return selection;
}

}  // namespace equilux
