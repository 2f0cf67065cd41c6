// What a disk holds after a power cut: all that was synced, and of the rest as much as the disk pleases.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include "base/random.h"
#include "tests/experiment/recording_vfs.h"
#include "tests/support/temp_folder.h"

namespace equilux {

/// Which unsynced changes a power cut leaves.
enum class Unsynced {
  kLost,  ///< none: the strictest disk that keeps its word
  kKept,  ///< all: as after kill -9
  kTorn,  ///< each sector of 512 bytes, each truncation, creation and deletion by the toss of a coin
};

class CrashedDisk {
 public:
  /// The files of a folder as they are: on the disk for certain.
  explicit CrashedDisk(const std::filesystem::path& folder) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.is_regular_file()) durable_[entry.path().string()] = read_bytes(entry.path());
    }
  }

  void take(const DiskStep& step) {
    if (step.kind == DiskStep::kPromise) return;
    std::vector<DiskStep>& pending = pending_[step.path];
    if (step.kind != DiskStep::kSync) pending.push_back(step);
    if (step.kind == DiskStep::kSync) {
      std::optional<std::string>& file = durable_[step.path];
      if (!file) file.emplace();
      for (const DiskStep& change : pending) apply(file, change);
      pending.clear();
    }
    if (step.syncs_folder) sync_names();
  }

  /// Writes what is left into a folder, under the same file names, in place of all that is there.
  void leave(const std::filesystem::path& folder, Unsynced unsynced, RandomStream& random) const {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) std::filesystem::remove_all(entry);
    std::map<std::string, std::optional<std::string>> files = durable_;
    for (const auto& [path, changes] : pending_) {
      for (const DiskStep& change : changes) {
        if (!keep(files[path], change, unsynced, random)) break;
      }
    }
    for (const auto& [path, bytes] : files) {
      if (bytes) std::ofstream(folder / std::filesystem::path(path).filename(), std::ios::binary) << *bytes;
    }
  }

 private:
  static constexpr std::size_t kSector = 512;

  // Which files there are, not what is in them.
  void sync_names() {
    for (auto& [path, pending] : pending_) {
      const auto removed = std::find_if(pending.rbegin(), pending.rend(), [](const DiskStep& step) {
                             return step.kind == DiskStep::kDelete;
                           }).base();
      if (removed != pending.begin()) durable_[path].reset();
      pending.erase(pending.begin(), removed);
      if (!pending.empty() && pending.front().kind == DiskStep::kCreate && !durable_[path])
        durable_[path].emplace();
    }
  }

  static void apply(std::optional<std::string>& file, const DiskStep& step) {
    if (step.kind == DiskStep::kDelete) return file.reset();
    if (!file) file.emplace();
    if (step.kind == DiskStep::kTruncate) file->resize(static_cast<std::size_t>(step.offset));
    if (step.kind != DiskStep::kWrite) return;
    const auto offset = static_cast<std::size_t>(step.offset);
    if (file->size() < offset + step.bytes.size()) file->resize(offset + step.bytes.size());
    file->replace(offset, step.bytes.size(), step.bytes);
  }

  // False if the name stays with what it meant before: the changes that follow are of another file.
  static bool keep(std::optional<std::string>& file, const DiskStep& step, Unsynced unsynced,
                   RandomStream& random) {
    if (unsynced == Unsynced::kLost) return false;
    if (unsynced == Unsynced::kKept || step.kind != DiskStep::kWrite) {
      const bool is_kept = unsynced == Unsynced::kKept || random.next_below(2) == 0;
      if (is_kept) apply(file, step);
      return is_kept || step.kind == DiskStep::kTruncate;
    }
    tear(file, step, random);
    return true;
  }

  static void tear(std::optional<std::string>& file, const DiskStep& step, RandomStream& random) {
    for (std::size_t done = 0; done < step.bytes.size();) {
      const std::size_t at = static_cast<std::size_t>(step.offset) + done;
      const std::size_t size = std::min(kSector - at % kSector, step.bytes.size() - done);
      if (random.next_below(2) == 0)
        apply(file,
              {DiskStep::kWrite, step.path, static_cast<std::int64_t>(at), step.bytes.substr(done, size)});
      done += size;
    }
  }

  std::map<std::string, std::optional<std::string>> durable_;
  std::map<std::string, std::vector<DiskStep>> pending_;
};

}  // namespace equilux
