// Refusals first, then writes.
#include "renderer/set_folder.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "protocols/session_protocol.h"
#include "renderer/picture_store.h"
#include "renderer/timing.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// What was shown was of one study: that of study.json, or of the manifest where it is lost.
void check_same_study(const StudyFolder& folder, const Study& study) {
  std::string shown = study.digest;
  if (path_exists(folder.study())) {
    shown = load_study(folder.study()).digest;
  } else if (path_exists(folder.manifest())) {
    shown = load_manifest(folder.manifest()).study_digest;
  }
  if (shown != study.digest) refuse_change(folder, "another study");
}

// A folder belongs to the study that was first rendered into it, whatever may become of that study.
void check_same_name(const StudyFolder& folder, const Study& study) {
  if (!path_exists(folder.study())) return;
  const Json shown = parse_json(load_text(folder.study()), folder.study().string());
  const Json* name = shown.find("name");
  if (name && name->is_string() && name->as_string() != study.name)
    throw InputError(folder.root.string(), "", fmt::format("the folder of the study \"{}\"", study.name),
                     fmt::format("that of \"{}\"; render into another folder", name->as_string()));
}

// A file that is copied once: windows and truth are a person's to edit once they are here.
struct CopiedFile {
  fs::path source, target;
};

CopiedFile windows_of(const StudyFolder& folder, const Study& study) {
  return {study.windows_path, folder.windows()};
}
CopiedFile truth_of(const StudyFolder& folder, const Study& study) {
  return {study.truth_path, folder.truth()};
}
CopiedFile session_of(const StudyFolder& folder, const Study& study) {
  return {study.session_path, folder.session()};
}

// The one that will be used.
const fs::path& choose(const CopiedFile& file) {
  return path_exists(file.target) ? file.target : file.source;
}

void copy_once(const CopiedFile& file) {
  if (!path_exists(file.target)) save_text(file.target, load_text(file.source));
}

}  // namespace

void check_own_folders(const StudyFolder& folder) {
  for (const fs::path& part :
       {folder.layer_folder(), folder.picture_folder(), folder.rooms(), folder.jobs()}) {
    std::error_code none;
    if (fs::is_symlink(part, none))
      throw InputError(part.string(), "", "a folder in the study folder",
                       "a symbolic link, which leads out of it; the study folder itself may be one");
  }
}

void check_set_folder(const StudyFolder& folder, const Study& study) {
  check_own_folders(folder);
  check_same_name(folder, study);
  if (has_sessions(folder)) check_same_study(folder, study);
  if (path_exists(folder.manifest())) load_manifest(folder.manifest());
  load_timing(folder);
  load_windows(choose(windows_of(folder, study)), study);
  load_truth(choose(truth_of(folder, study)), study);
  if (!study.session_path.empty()) load_session_protocol(choose(session_of(folder, study)));
}

void fill_set_folder(const StudyFolder& folder, const Study& study) {
  for (const fs::path& part : {folder.root, folder.layer_folder(), folder.picture_folder()}) {
    make_folder(part);
    remove_stale_parts(part);
  }
  copy_once(windows_of(folder, study));
  copy_once(truth_of(folder, study));
  if (!study.session_path.empty()) copy_once(session_of(folder, study));
  save_text(folder.study(), format_json(study.source));
}

}  // namespace equilux
