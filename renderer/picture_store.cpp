// Pictures on disk.
#include "renderer/picture_store.h"

#include <set>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "stimuli/change_mark.h"
#include "stimuli/png_file.h"
#include "stimuli/verdict.h"

namespace equilux {
namespace {

std::string file_of(const std::string& key) { return "pictures/" + key + ".png"; }

}  // namespace

bool has_sessions(const StudyFolder& folder) { return path_exists(folder.responses()); }

void refuse_change(const StudyFolder& folder, const std::string& what) {
  throw InputError(folder.root.string(), "",
                   "what its sessions have seen: " + folder.responses().string() + " exists",
                   what + "; render into a new folder");
}

void begin_change(const StudyFolder& folder, const std::string& what) {
  const bool is_first = find_change_mark(folder).empty();
  if (is_first) save_change_mark(folder);
  if (!has_sessions(folder)) return;
  if (is_first) remove_change_mark(folder);
  refuse_change(folder, what);
}

PictureStore::PictureStore(StudyFolder folder, const Study& study)
    : folder_(std::move(folder)), is_doubted_(!find_verdict(folder_).empty()) {
  if (path_exists(folder_.manifest())) take_earlier(study);
  manifest_.study_name = study.name;
  manifest_.study_digest = study.digest;
  manifest_.seed = study.seed;
  manifest_.width = study.width;
  manifest_.height = study.height;
  manifest_.noise_target = study.noise_target;
}

void PictureStore::take_earlier(const Study& study) {
  Manifest found = load_manifest(folder_.manifest());
  std::set<std::string> known;
  for (const Condition& condition : enumerate_conditions(study)) known.insert(format_key(condition));
  for (const Family& family : enumerate_references(study)) known.insert(format_key(family));
  std::erase_if(found.pictures, [&](const auto& entry) { return !known.contains(entry.first); });
  std::erase_if(found.tones, [&](const auto& entry) { return !known.contains(entry.first); });
  if (found.study_digest == study.digest) {
    manifest_ = std::move(found);
  } else {
    earlier_ = std::move(found.pictures);
  }
}

const PictureRecord* PictureStore::find(const std::string& key) const {
  for (const Records* records : {&manifest_.pictures, &earlier_}) {
    const auto found = records->find(key);
    if (found != records->end()) return &found->second;
  }
  return nullptr;
}

bool PictureStore::has_digest(const std::filesystem::path& path, const std::string& digest) const {
  try {  // of a file that may be anybody's: the boundary to making it again
    return is_file(path) && digest_file(path, most_file_bytes({manifest_.width, manifest_.height})) == digest;
  } catch (const InputError&) {
    return false;
  }
}

bool PictureStore::keep(const std::string& key, const PictureRecord& wanted) {
  PictureRecord record;
  {
    const std::lock_guard lock(mutex_);
    const PictureRecord* found = find(key);
    if (!found || found->made_from != wanted.made_from || found->file != file_of(key)) return false;
    record = *found;
  }
  const std::filesystem::path path = folder_.root / record.file;
  if (!has_digest(path, record.digest)) return false;
  const std::lock_guard lock(mutex_);
  manifest_.pictures[key] = {record.file,           record.digest,    wanted.made_from,
                             wanted.standard_error, wanted.reference, wanted.vpls};
  return true;
}

bool PictureStore::shows(const std::string& key, const LdrImage& picture) const {
  const std::filesystem::path path = folder_.root / file_of(key);
  try {  // of a file that may be anybody's: the boundary to making it again
    return load_png_size(path) == PixelSize{picture.width, picture.height} &&
           load_png(path).values == picture.values;
  } catch (const InputError&) {
    return false;
  }
}

void PictureStore::save(const std::string& key, PictureRecord wanted, const LdrImage& picture) {
  const std::string bytes = encode_png(picture);
  wanted.digest = digest_text(bytes);
  wanted.file = file_of(key);
  {
    const std::lock_guard lock(mutex_);
    const PictureRecord* found = find(key);
    if (found && found->digest != wanted.digest) begin_change(folder_, "another " + key);
  }
  save_text(folder_.root / wanted.file, bytes);
  const std::lock_guard lock(mutex_);
  manifest_.pictures[key] = std::move(wanted);
}

void PictureStore::set_tone(const std::string& reference_key, const ToneRecord& tone) {
  manifest_.tones[reference_key] = tone;
}

void PictureStore::save_record() const { save_manifest(manifest_, folder_.manifest()); }

}  // namespace equilux
