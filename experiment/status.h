// Who has answered how much: what an experimenter asks the log between two subjects.
#pragma once

#include <string>

#include "stimuli/study_folder.h"

namespace equilux {

/// A table of the folder's sessions, one line each: state (an abort's reason last), answers and too fast ones
/// of all phases, catch trials right of those answered; then how many participants withdrew and the index
/// that the next subject gets. Read from a snapshot: a session may be going on. errors: InputError,
/// StoreError
std::string format_status(const StudyFolder& folder);

}  // namespace equilux
