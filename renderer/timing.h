// timing.json: times, host and instruction set of every run that made something. No digest covers it.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "base/json.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// The runs so far; an empty array where there is no file. errors: InputError if it is damaged.
Json load_timing(const StudyFolder& folder);

/// `seconds` by stage. errors: InputError, StoreError
void append_timing(const StudyFolder& folder, const std::map<std::string, double>& seconds,
                   std::size_t layers_rendered, std::size_t pictures_written);

}  // namespace equilux
