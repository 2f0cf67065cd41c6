// Pictures on disk.
#include "renderer/picture_store.h"

#include <set>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "stimuli/png_file.h"

namespace equilux {

bool has_sessions(const StudyFolder& folder) { return path_exists(folder.responses()); }

void refuse_change(const StudyFolder& folder, const std::string& what) {
  throw InputError(folder.root.string(), "",
                   "what its sessions have seen: " + folder.responses().string() + " exists",
                   what + "; render into a new folder");
}

PictureStore::PictureStore(StudyFolder folder, const Study& study)
    : folder_(std::move(folder)), locked_(has_sessions(folder_)) {
  if (path_exists(folder_.manifest())) manifest_ = load_manifest(folder_.manifest());
  manifest_.study_name = study.name;
  manifest_.study_digest = study.digest;
  manifest_.seed = study.seed;
  manifest_.width = study.width;
  manifest_.height = study.height;
  manifest_.noise_target = study.noise_target;
  drop_others(study);
}

std::optional<PictureRecord> PictureStore::find(const std::string& key) const {
  const std::lock_guard lock(mutex_);
  const auto found = manifest_.pictures.find(key);
  return found == manifest_.pictures.end() ? std::nullopt : std::optional(found->second);
}

bool PictureStore::is_whole(const std::string& key, const std::string& made_from) const {
  const auto found = find(key);
  if (!found || found->made_from != made_from) return false;
  const std::filesystem::path path = folder_.root / found->file;
  return is_file(path) && digest_file(path) == found->digest;
}

void PictureStore::save(const std::string& key, const std::string& made_from, const LdrImage& picture) {
  const std::string bytes = encode_png(picture);
  const std::string digest = digest_text(bytes);
  const auto found = find(key);
  if (locked_ && found && found->digest != digest) refuse_change(folder_, "another " + key);
  const std::string file = "pictures/" + key + ".png";
  save_text(folder_.root / file, bytes);
  const std::lock_guard lock(mutex_);
  manifest_.pictures[key] = {file, digest, made_from, {}, {}, {}};
}

void PictureStore::set_error(const std::string& key, Json standard_error, Json reference) {
  PictureRecord& record = manifest_.pictures.at(key);
  record.standard_error = std::move(standard_error);
  record.reference = std::move(reference);
}

void PictureStore::set_vpls(const std::string& key, Json vpls) {
  manifest_.pictures.at(key).vpls = std::move(vpls);
}

void PictureStore::set_tone(const std::string& reference_key, const ToneRecord& tone) {
  manifest_.tones[reference_key] = tone;
}

void PictureStore::save_record() const { save_manifest(manifest_, folder_.manifest()); }

void PictureStore::drop_others(const Study& study) {
  std::set<std::string> known;
  for (const Condition& condition : enumerate_conditions(study)) known.insert(format_key(condition));
  for (const Family& family : enumerate_references(study)) known.insert(format_key(family));
  std::erase_if(manifest_.pictures, [&](const auto& entry) { return !known.contains(entry.first); });
  std::erase_if(manifest_.tones, [&](const auto& entry) { return !known.contains(entry.first); });
}

}  // namespace equilux
