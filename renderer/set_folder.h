// The folder of a set: whether a run may write into it, and what stands there before layers do.
#pragma once

#include "protocols/study.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// errors: InputError where a folder in it is a symbolic link: what is written and removed is the set's own
void check_own_folders(const StudyFolder& folder);

/// Writes nothing. errors: as check_own_folders; InputError for the folder of another study, or of another
/// version where there are sessions; for records that are damaged; for windows, truth or session protocol
/// that cannot be used
void check_set_folder(const StudyFolder& folder, const Study& study);

/// Makes the folders, copies windows, truth and session protocol unless they are there, and writes study.json
/// last. errors: StoreError
void fill_set_folder(const StudyFolder& folder, const Study& study);

}  // namespace equilux
