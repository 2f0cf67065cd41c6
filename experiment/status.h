// Who has answered how much: what an experimenter asks the log between two subjects.
#pragma once

#include <string>

#include "stimuli/study_folder.h"

namespace equilux {

/// A table of the folder's sessions, one line each. errors: InputError, StoreError
std::string format_status(const StudyFolder& folder);

}  // namespace equilux
