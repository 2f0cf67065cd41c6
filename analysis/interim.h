// What the answers so far say, while sessions go on: the one header of analysis that the window may use.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/equivalence.h"
#include "stimuli/study_folder.h"

namespace equilux {

struct SessionCounts {
  std::int64_t finished = 0;    ///< these count
  std::int64_t unfinished = 0;  ///< going on, interrupted or aborted
};

struct InterimFindings {
  SessionCounts artifact;
  SessionCounts material;
  std::vector<ColumnFinding>
      columns;  ///< as find_equivalence gives them; all untested before the first answer
};

/// Of the finished sessions of a kind in the folder's log, read from a snapshot: a running session is not
/// disturbed. Without a log nothing is tested. errors: InputError for a log that is none, or has finished
/// sessions of another study; StoreError
InterimFindings load_interim(const StudyFolder& folder, const Study& study, SubjectKind kind);

}  // namespace equilux
