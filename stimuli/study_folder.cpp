// Opening a study folder.
#include "stimuli/study_folder.h"

#include "base/error.h"

namespace equilux {

Study load_folder_study(const StudyFolder& folder) {
  if (!std::filesystem::exists(folder.study())) {
    throw InputError(
        folder.root.string(), "", "a study folder made by `equilux-render set`",
        std::filesystem::exists(folder.root) ? "a folder without study.json" : "nothing of that name");
  }
  Study study = load_study(folder.study());
  study.windows_path = folder.windows();
  study.truth_path = folder.truth();
  return study;
}

}  // namespace equilux
