// What the study workspace shows: what a set holds and lacks, how often each cell was answered, and the
// windows that the experimenter moves by hand. Values alone, no window.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/trial_log.h"
#include "protocols/windows.h"
#include "stimuli/image.h"
#include "stimuli/manifest.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// Pictures that a study's sessions may need: VPL pictures and references of both views.
struct Holding {
  int there = 0;
  std::vector<std::string> missing;  ///< keys
};

/// In the manifest, with a file in the study folder `root`; without a manifest all are missing.
Holding find_holding(const Study& study, const std::optional<Manifest>& manifest,
                     const std::filesystem::path& root);

/// Answers to a cell so far.
struct CellCount {
  int right = 0;
  int answered = 0;
};
using Coverage = std::map<Cell, CellCount>;

/// Of counted answers, as TrialLog::load_answers gives them.
Coverage tally_coverage(const std::vector<AnswerRow>& answers);

/// windows.json with the window of one column moved by `steps` levels, more clamped for positive ones, and
/// its origin by_eye; as far as the study's levels go. errors: InputError for a column without a window
Json shift_window(const Study& study, const Json& windows, const Column& column, int steps);

/// The same in a folder's file. errors: InputError once an artifact session has begun, since it was made from
/// the windows as they are; StoreError
Windows save_shifted_window(const StudyFolder& folder, const Study& study, const Column& column, int steps);

/// What two pictures of one size differ by: 128 and `gain` times the difference, in displayed values.
LdrImage make_difference(const LdrImage& picture, const LdrImage& reference, int gain);

/// Smaller by a whole factor, each pixel the mean of displayed values; what does not fill a pixel is left
/// out.
LdrImage make_thumbnail(const LdrImage& picture, int factor);

}  // namespace equilux
