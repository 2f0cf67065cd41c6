// The pictures of a study folder and their records. One that may have been shown is never replaced by
// another.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "stimuli/image.h"
#include "stimuli/manifest.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// True once subjects may have seen pictures: the session program makes the log with its first session.
bool has_sessions(const StudyFolder& folder);

/// errors: always InputError: `what` would change the pictures of a folder with sessions.
[[noreturn]] void refuse_change(const StudyFolder& folder, const std::string& what);

/// Before anything that may be shown is replaced: marks the folder (change_mark.h) and looks for sessions
/// after that, as one that begins looks for the mark after it has made the log. errors: as refuse_change,
/// where there are sessions; StoreError
void begin_change(const StudyFolder& folder, const std::string& what);

/// Its manifest holds pictures of today's study alone, at any moment: those of an earlier run of the same
/// study, and those that were kept or saved since. `keep` and `save` are thread-safe beside each other.
class PictureStore {
 public:
  /// Opens what an earlier run left; records of pictures that the study does not have are dropped.
  PictureStore(StudyFolder folder, const Study& study);

  /// True if the picture is on disk, under its key's name and as recorded, and was made from what `wanted`
  /// says; then its record says the rest of `wanted` too, which has no file and no digest.
  bool keep(const std::string& key, const PictureRecord& wanted);

  /// Faults were found and not looked at again (see verdict.h): records are not to be believed.
  bool is_doubted() const { return is_doubted_; }

  /// Whether the file of this key has these pixels.
  bool shows(const std::string& key, const LdrImage& picture) const;

  /// errors: InputError if the picture may have been shown and is another now; StoreError.
  void save(const std::string& key, PictureRecord wanted, const LdrImage& picture);

  void set_tone(const std::string& reference_key, const ToneRecord& tone);

  /// Writes manifest.json. errors: StoreError
  void save_record() const;

 private:
  using Records = std::map<std::string, PictureRecord>;

  void take_earlier(const Study& study);
  const PictureRecord* find(const std::string& key) const;
  bool has_digest(const std::filesystem::path& path, const std::string& digest) const;

  StudyFolder folder_;
  bool is_doubted_;
  Manifest manifest_;
  Records earlier_;   ///< of a run of another version of the study: they may still be whole
  std::mutex mutex_;  ///< of the records
};

}  // namespace equilux
