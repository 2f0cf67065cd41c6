// Opening a study folder.
#include "stimuli/study_folder.h"

#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {

// What a study extends may lie anywhere; a folder is carried around whole.
void refuse_extension(const std::filesystem::path& path) {
  const Json json = parse_json(load_text(path), path.string());
  if (const Json* base = json.find("extends")) {
    throw InputError(path.string(), "/extends", "the whole study, as `equilux-render set` writes it",
                     describe_json(*base));
  }
}

}  // namespace

Study load_folder_study(const StudyFolder& folder) {
  if (!path_exists(folder.study())) {
    throw InputError(folder.root.string(), "", "a study folder made by `equilux-render set`",
                     !path_exists(folder.root) ? "nothing of that name"
                     : is_file(folder.root)    ? "a file"
                                               : "a folder without study.json");
  }
  refuse_extension(folder.study());
  Study study = load_study(folder.study());
  study.windows_path = folder.windows();
  study.truth_path = folder.truth();
  study.session_path = folder.session();
  return study;
}

}  // namespace equilux
