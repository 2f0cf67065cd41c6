// The pictures of a study folder and their records. One that may have been shown is never replaced by
// another.
#pragma once

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

class PictureStore {
 public:
  /// Opens what an earlier run left; records of pictures that the study does not have are dropped.
  PictureStore(StudyFolder folder, const Study& study);

  /// True if the picture is on disk as recorded and was made from this. Thread-safe beside save.
  bool is_whole(const std::string& key, const std::string& made_from) const;

  /// Thread-safe. errors: InputError if the picture may have been shown and is another now; StoreError.
  void save(const std::string& key, const std::string& made_from, const LdrImage& picture);

  /// What the record of a reference that is there says of its error, and how it was made.
  void set_error(const std::string& key, Json standard_error, Json reference);
  /// The same of a VPL picture.
  void set_vpls(const std::string& key, Json vpls);

  void set_tone(const std::string& reference_key, const ToneRecord& tone);

  /// Writes manifest.json. errors: StoreError
  void save_record() const;

 private:
  void drop_others(const Study& study);
  std::optional<PictureRecord> find(const std::string& key) const;

  StudyFolder folder_;
  bool locked_;
  Manifest manifest_;
  mutable std::mutex mutex_;  ///< of the records
};

}  // namespace equilux
