// Opening a study folder.
#include "stimuli/study_folder.h"

#include "base/error.h"
#include "base/files.h"

namespace equilux {

Study load_folder_study(const StudyFolder& folder) {
  if (!path_exists(folder.study())) {
    throw InputError(folder.root.string(), "", "a study folder made by `equilux-render set`",
                     path_exists(folder.root) ? "a folder without study.json" : "nothing of that name");
  }
  Study study = load_study(folder.study());
  study.windows_path = folder.windows();
  study.truth_path = folder.truth();
  study.session_path = folder.session();
  return study;
}

}  // namespace equilux
