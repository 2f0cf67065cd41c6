// A whole stimulus set: from a study to its layers, pictures and manifest.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/folder_lock.h"
#include "protocols/study.h"
#include "renderer/cut_error.h"
#include "renderer/jobs.h"
#include "renderer/tone.h"
#include "stimuli/verify_pictures.h"

namespace equilux {

struct SetParams {
  std::filesystem::path study_path;
  std::filesystem::path folder;
  std::string only = "*";                         ///< glob over keys of pictures and references
  std::optional<JobShare> job = {};               ///< this share alone, into a folder of its own; no pictures
  std::vector<std::filesystem::path> reuse = {};  ///< study folders whose layers may be taken over
  bool render = true;                             ///< false: only gather, and refuse what is still missing
  std::chrono::milliseconds patience = kLockPatience;  ///< with a folder that somebody else writes
  /// Told why shares were not gathered, where something is missing that is rendered then.
  std::function<void(const std::string&)> remark = {};
};

/// What a run did. units: s
struct SetSummary {
  std::size_t pictures = 0;          ///< in the manifest that the glob names
  std::size_t pictures_written = 0;  ///< by this run
  std::size_t layers_rendered = 0;   ///< by this run
  std::size_t layers_adopted = 0;    ///< by this run, from other folders
  std::map<std::string, double> seconds;
  double processor_seconds = 0;               ///< of all threads
  double peak_memory = 0;                     ///< of the process; 0: not told. units: bytes
  std::map<std::string, DisplayNoise> noise;  ///< by key of the reference
  NoiseTarget target;
  bool fixes_paths = false;                         ///< the study: no reference is held to the target
  std::map<std::int64_t, ErrorSummary> cut_errors;  ///< by VPL count, pooled over pictures by cuts
  std::vector<std::string> warnings;                ///< what is legal and hardly ever meant
  std::vector<std::string> missed;  ///< limits that layers do not keep, and that the same study never will
  std::vector<Finding> findings;    ///< of a whole verification at the end, where an earlier one had some
};

/// Gathers what shares have left, renders what is missing, then tone-maps. What is whole on disk and made
/// from the same is kept; a run that was stopped goes on. Where the folder holds sessions, a picture that may
/// have been shown is never changed. While a verdict tells of faults (verdict.h) pictures are compared with
/// their layers, whatever records say, and the set is verified at the end. While pictures that may be shown
/// are replaced the folder is marked (change_mark.h). A share stays in its folder in
/// DIR/jobs until it is gathered. errors: InputError, StoreError; WorkCancelled where this thread's work is
/// controlled: what is whole is kept
SetSummary make_set(const SetParams& params);

/// Tone-maps the layers of a folder again, by its own study file, and verifies as make_set does. errors:
/// InputError if a layer is missing.
SetSummary tonemap_set(const std::filesystem::path& folder, const std::string& only = "*");

/// Nothing was found or missed: sessions may begin on what was made.
bool is_within_limits(const SetSummary& summary);

std::string format_summary(const SetSummary& summary);

}  // namespace equilux
