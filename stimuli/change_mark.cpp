// A file for a person to read; its name says all that programs ask.
#include "stimuli/change_mark.h"

#include "base/error.h"
#include "base/files.h"

namespace equilux {

void save_change_mark(const StudyFolder& folder) {
  save_text(folder.changing(),
            "Pictures of this folder are being made anew, or were when a run was ended. No session begins "
            "until\n`equilux-render set` with the study file, and without --only, has made them whole.\n");
}

void remove_change_mark(const StudyFolder& folder) {
  std::error_code error;
  std::filesystem::remove(folder.changing(), error);
  if (error)
    throw StoreError(fmt::format("{}: cannot remove: {}", folder.changing().string(), error.message()));
}

std::vector<Finding> find_change_mark(const StudyFolder& folder) {
  if (!path_exists(folder.changing())) return {};
  return {{folder.changing().string(),
           "pictures are being made anew, or were when a run was ended; `equilux-render set` without --only "
           "makes them whole"}};
}

}  // namespace equilux
