// SQLite's way to the disk, with every change of a file written down; and a disk that can die at any of them.
#pragma once

#include <cstdint>
#include <limits>
#include <new>
#include <sqlite3.h>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"

namespace equilux {

/// A change that a program asked the system for; or, between them, something that it promised to its user.
struct DiskStep {
  enum Kind { kCreate, kWrite, kTruncate, kSync, kDelete, kPromise };
  Kind kind = kWrite;
  std::string path;
  std::int64_t offset = 0;  ///< of a write; of a truncation the size that is left; of a promise its number
  std::string bytes = {};
  bool syncs_folder = false;  ///< of a sync or deletion: names made and removed are on the disk too
};

/// While it lives it is SQLite's default VFS. One at a time.
class RecordingVfs {
 public:
  RecordingVfs() : real_(sqlite3_vfs_find(nullptr)), vfs_(*real_) {
    vfs_.zName = "recording";
    vfs_.szOsFile = static_cast<int>(sizeof(File)) + real_->szOsFile;
    vfs_.xOpen = &open;
    vfs_.xDelete = &remove;
    living_ = this;
    EQ_CHECK(sqlite3_vfs_register(&vfs_, 1) == SQLITE_OK);
  }
  ~RecordingVfs() {
    sqlite3_vfs_unregister(&vfs_);
    sqlite3_vfs_register(real_, 1);
    living_ = nullptr;
  }
  RecordingVfs(const RecordingVfs&) = delete;
  RecordingVfs& operator=(const RecordingVfs&) = delete;

  void promise(std::int64_t number) { steps_.push_back({DiskStep::kPromise, "", number}); }
  const std::vector<DiskStep>& steps() const { return steps_; }
  /// From that step on every change fails with this code of SQLite's.
  void fail_from(std::size_t step, int code) {
    first_failure_ = step;
    failure_ = code;
  }

 private:
  struct File {
    sqlite3_file base;
    sqlite3_file* real;  ///< right behind
    std::string* path;   ///< empty for temporary files, which are not recorded
    bool syncs_folder;   ///< at its first sync, as SQLite's own VFS does for new journals and WALs
  };

  // SQLITE_OK if the change may happen.
  int record(DiskStep step) {
    if (step.path.empty()) return SQLITE_OK;
    if (steps_.size() >= first_failure_) {
      return failure_;
    }
    steps_.push_back(std::move(step));
    return SQLITE_OK;
  }

  static File& of(sqlite3_file* file) { return *reinterpret_cast<File*>(file); }
  static sqlite3_file* real_of(sqlite3_file* file) { return of(file).real; }
  template <typename Call>
  static int change(sqlite3_file* file, DiskStep step, const Call& call) {
    step.path = *of(file).path;
    const int refused = living_->record(std::move(step));
    return refused == SQLITE_OK ? call(real_of(file)) : refused;
  }

  static int open(sqlite3_vfs*, const char* name, sqlite3_file* file, int flags, int* out_flags) {
    sqlite3_vfs* real = living_->real_;
    File& opened =
        *::new (file) File{{nullptr}, reinterpret_cast<sqlite3_file*>(&of(file) + 1), nullptr, false};
    int exists = 1;
    if (name) real->xAccess(real, name, SQLITE_ACCESS_EXISTS, &exists);
    const int code = real->xOpen(real, name, opened.real, flags, out_flags);
    if (!opened.real->pMethods) return code;
    opened.path = new std::string(name ? name : "");
    opened.base.pMethods = &methods();
    opened.syncs_folder =
        (flags & SQLITE_OPEN_CREATE) && (flags & (SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_WAL));
    if (code == SQLITE_OK && !exists) living_->steps_.push_back({DiskStep::kCreate, name});
    return code;
  }
  static int remove(sqlite3_vfs*, const char* name, int sync_folder) {
    const int refused = living_->record({DiskStep::kDelete, name, 0, "", sync_folder != 0});
    return refused == SQLITE_OK ? living_->real_->xDelete(living_->real_, name, sync_folder) : refused;
  }
  static int close(sqlite3_file* file) {
    const int code = real_of(file)->pMethods->xClose(real_of(file));
    delete of(file).path;
    return code;
  }
  static int write(sqlite3_file* file, const void* bytes, int size, sqlite3_int64 offset) {
    const std::string text(static_cast<const char*>(bytes), static_cast<std::size_t>(size));
    return change(file, {DiskStep::kWrite, "", offset, text},
                  [&](sqlite3_file* real) { return real->pMethods->xWrite(real, bytes, size, offset); });
  }
  static int truncate(sqlite3_file* file, sqlite3_int64 size) {
    return change(file, {DiskStep::kTruncate, "", size},
                  [&](sqlite3_file* real) { return real->pMethods->xTruncate(real, size); });
  }
  static int sync(sqlite3_file* file, int flags) {
    const bool syncs_folder = std::exchange(of(file).syncs_folder, false);
    return change(file, {DiskStep::kSync, "", 0, "", syncs_folder},
                  [&](sqlite3_file* real) { return real->pMethods->xSync(real, flags); });
  }

  // What changes nothing goes on to the real file. Version 2: with the WAL's index, without mapped pages.
  static const sqlite3_io_methods& methods() {
    using F = sqlite3_file*;
    static const sqlite3_io_methods all = {
        2,
        &close,
        [](F f, void* to, int size, sqlite3_int64 at) {
          return real_of(f)->pMethods->xRead(real_of(f), to, size, at);
        },
        &write,
        &truncate,
        &sync,
        [](F f, sqlite3_int64* size) { return real_of(f)->pMethods->xFileSize(real_of(f), size); },
        [](F f, int lock) { return real_of(f)->pMethods->xLock(real_of(f), lock); },
        [](F f, int lock) { return real_of(f)->pMethods->xUnlock(real_of(f), lock); },
        [](F f, int* out) { return real_of(f)->pMethods->xCheckReservedLock(real_of(f), out); },
        [](F f, int what, void* with) { return real_of(f)->pMethods->xFileControl(real_of(f), what, with); },
        [](F f) { return real_of(f)->pMethods->xSectorSize(real_of(f)); },
        [](F f) { return real_of(f)->pMethods->xDeviceCharacteristics(real_of(f)); },
        [](F f, int page, int size, int extend, void volatile** out) {
          return real_of(f)->pMethods->xShmMap(real_of(f), page, size, extend, out);
        },
        [](F f, int at, int count, int flags) {
          return real_of(f)->pMethods->xShmLock(real_of(f), at, count, flags);
        },
        [](F f) { real_of(f)->pMethods->xShmBarrier(real_of(f)); },
        [](F f, int remove_it) { return real_of(f)->pMethods->xShmUnmap(real_of(f), remove_it); },
        nullptr,
        nullptr};
    return all;
  }

  inline static RecordingVfs* living_ = nullptr;
  sqlite3_vfs* real_;
  sqlite3_vfs vfs_;
  std::vector<DiskStep> steps_;
  std::size_t first_failure_ = std::numeric_limits<std::size_t>::max();
  int failure_ = SQLITE_OK;
};

}  // namespace equilux
