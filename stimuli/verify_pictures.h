// Is what may be shown what was made, and good enough? Asked before a subject sees it.
#pragma once

#include <string>
#include <vector>

#include "stimuli/manifest.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// Something that is not as it must be, of a picture, a layer or a file.
struct Finding {
  std::string what;  ///< key of a picture, name of a layer or of a file
  std::string wrong;
  bool by_study_file = false;  ///< the folder alone does not show it
  bool operator==(const Finding&) const = default;
};

/// "G0-MS-ind-ref-v0: no picture".
std::string format_finding(const Finding& finding);

/// Keys of every picture that a study has: conditions and references.
std::vector<std::string> enumerate_pictures(const Study& study);

/// Those, and what the manifest has beside them.
std::vector<std::string> list_pictures(const Study& study, const Manifest& manifest);

/// Checks these pictures: recorded, as pictures/KEY.png; the file there, readable, of its digest and size; a
/// tone curve of its family; made by it from the layers that layers.json records, where there is one; a
/// reference's standard error within the study's target, where it has one. A picture of another study is the
/// manifest's finding, and so are another name, seed, size or target than the study's and a key that the
/// study does not have. Reads every picture and no layer.
std::vector<Finding> verify_pictures(const StudyFolder& folder, const Study& study, const Manifest& manifest,
                                     const std::vector<std::string>& keys);

/// errors: InputError that tells the first and how many there are
void refuse_findings(const std::vector<Finding>& findings, const StudyFolder& folder);

}  // namespace equilux
