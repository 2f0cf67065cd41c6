// verdict.json: what `equilux-render verify` found last, for the programs that show and count pictures. A set
// in which it found nothing has none.
#pragma once

#include <vector>

#include "stimuli/study_folder.h"
#include "stimuli/verify_pictures.h"

namespace equilux {

/// Writes it beside the records that it is about; where nothing was found it goes. errors: StoreError
void save_verdict(const StudyFolder& folder, const std::vector<Finding>& findings);

/// The same after the whole folder was looked at. What was found against a study file stands where there was
/// none this time: then it is added to the findings and nothing is written. Gives the findings. errors:
/// StoreError; InputError for an earlier verdict that is damaged
std::vector<Finding> renew_verdict(const StudyFolder& folder, std::vector<Finding> findings,
                                   bool has_study_file);

/// What was found, as one finding that tells whether manifest.json or layers.json were changed since; a
/// record that was changed by hand is not verified by that. Empty where nothing was found. errors: InputError
/// for a file that is damaged
std::vector<Finding> find_verdict(const StudyFolder& folder);

}  // namespace equilux
