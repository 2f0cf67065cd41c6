// One writer for each folder.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

namespace equilux {

/// Held by one process while it writes into a folder, on a file .lock there that names it meanwhile; the
/// system lets go of it however the process ends. errors: StoreError if the folder cannot be written, or its
/// file system has no locks: two that write one folder would spoil it
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Another process holds it, or has moved the folder away meanwhile.
  bool is_busy() const { return busy_; }

  /// Of a busy one who holds it, as "process 4711 on HOST"; empty where its file does not tell.
  const std::string& holder() const { return holder_; }

 private:
  std::filesystem::path path_;
  int descriptor_;
  bool busy_ = false;
  std::string holder_;
};

/// How long a folder that is being written is asked for again: others look at its lock for an instant.
inline constexpr std::chrono::milliseconds kLockPatience{5000};

/// Locks a folder, which is made where it is not there. errors: InputError if it is busy all the time;
/// StoreError; WorkCancelled
std::unique_ptr<FolderLock> lock_folder(const std::filesystem::path& folder,
                                        std::chrono::milliseconds patience = kLockPatience);

}  // namespace equilux
