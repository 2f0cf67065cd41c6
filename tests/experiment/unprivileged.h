// Permissions mean nothing to root; a test of them runs as nobody.
#pragma once

#include <filesystem>
#include <unistd.h>

#include "base/error.h"

namespace equilux {

/// While it lives, a process of root's has the rights of nobody, to whom `folder` and all in it belong; any
/// other process stays as it is. The folder can only be read, and so can its files.
class ReadOnlyFolder {
 public:
  explicit ReadOnlyFolder(const std::filesystem::path& folder) : folder_(folder) {
    give_away(folder_);
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      give_away(entry.path());
      set_writable(entry.path(), false);
    }
    set_writable(folder_, false);
    if (is_root_) EQ_CHECK(::seteuid(kNobody) == 0);
  }
  ~ReadOnlyFolder() {
    if (is_root_) EQ_CHECK(::seteuid(0) == 0);
    set_writable(folder_, true);
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) set_writable(entry.path(), true);
  }
  ReadOnlyFolder(const ReadOnlyFolder&) = delete;
  ReadOnlyFolder& operator=(const ReadOnlyFolder&) = delete;

 private:
  static constexpr uid_t kNobody = 65534;

  void give_away(const std::filesystem::path& path) const {
    if (is_root_) EQ_CHECK(::chown(path.c_str(), kNobody, static_cast<gid_t>(-1)) == 0, path.string());
  }
  static void set_writable(const std::filesystem::path& path, bool writable) {
    namespace fs = std::filesystem;
    fs::permissions(path, fs::perms::owner_write,
                    writable ? fs::perm_options::add : fs::perm_options::remove);
  }

  std::filesystem::path folder_;
  bool is_root_ = ::geteuid() == 0;
};

}  // namespace equilux
