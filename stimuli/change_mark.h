// changing.txt: pictures that may be shown are being replaced, or a run that did so was ended, however it
// was.
#pragma once

#include <vector>

#include "stimuli/study_folder.h"
#include "stimuli/verify_pictures.h"

namespace equilux {

/// Before the first is replaced. errors: StoreError
void save_change_mark(const StudyFolder& folder);

/// When all are whole. errors: StoreError
void remove_change_mark(const StudyFolder& folder);

/// The mark, as a finding.
std::vector<Finding> find_change_mark(const StudyFolder& folder);

}  // namespace equilux
