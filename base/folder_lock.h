// One writer for each folder.
#pragma once

#include <filesystem>

namespace equilux {

/// Held by one process while it writes into a folder, on an empty file .lock there; the system lets go of it
/// however the process ends. errors: StoreError if the folder cannot be written, or its file system has no
/// locks: two that write one folder would spoil it
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Another process holds it.
  bool is_busy() const { return busy_; }

 private:
  int descriptor_;
  bool busy_ = false;
};

/// errors: InputError if the lock is busy
void check_not_busy(const FolderLock& lock, const std::filesystem::path& folder);

}  // namespace equilux
