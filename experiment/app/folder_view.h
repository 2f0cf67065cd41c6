// What the workspace reads of a study folder, anew whenever it may have changed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiment/browse.h"

namespace equilux {

struct FolderView {
  Study study;
  std::optional<Manifest> manifest;
  Holding holding;
  std::optional<Windows> windows;
  Coverage artifact, material;
};

/// errors: InputError, StoreError
FolderView read_folder_view(const StudyFolder& folder, SubjectKind kind);

/// The answers so far alone; none where there is no log. errors: InputError, StoreError
void read_coverage(const StudyFolder& folder, SubjectKind kind, FolderView& view);

/// VPL counts that the study has of an object, in its order.
std::vector<std::int64_t> list_counts(const Study& study, const Object& object);

/// "a 9/12!": right of answered, marked where flagged; empty without answers.
std::string describe_count(const Coverage& coverage, const Cell& cell, const char* name);

}  // namespace equilux
