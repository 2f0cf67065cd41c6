// verdict.json: what `equilux-render verify` found last, for the programs that show and count pictures. A set
// in which it found nothing has none.
#pragma once

#include <vector>

#include "stimuli/study_folder.h"
#include "stimuli/verify_pictures.h"

namespace equilux {

/// Writes it beside the records that it is about; where nothing was found it goes. errors: StoreError
void save_verdict(const StudyFolder& folder, const std::vector<Finding>& findings);

/// Before the folder is changed. errors: StoreError
void remove_verdict(const StudyFolder& folder);

/// What was found, as one finding that tells whether manifest.json or layers.json were changed since; a
/// record that was changed by hand is not verified by that. Empty where nothing was found. errors: InputError
/// for a file that is damaged
std::vector<Finding> find_verdict(const StudyFolder& folder);

}  // namespace equilux
