// An advisory lock of the system on a file of its own.
#include "base/folder_lock.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "base/error.h"

namespace equilux {

FolderLock::FolderLock(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / ".lock";
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw StoreError(fmt::format("{}: cannot open: {}", path.string(), std::strerror(errno)));
  int result = 0;
  do {
    result = ::flock(descriptor_, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  busy_ = result != 0 && errno == EWOULDBLOCK;
  if (result == 0 || busy_) return;
  const std::string why = std::strerror(errno);
  ::close(descriptor_);
  throw StoreError(
      fmt::format("{}: cannot be locked: {}; a folder is written where the file system keeps two programs "
                  "apart",
                  path.string(), why));
}

FolderLock::~FolderLock() { ::close(descriptor_); }

void check_not_busy(const FolderLock& lock, const std::filesystem::path& folder) {
  if (lock.is_busy())
    throw InputError(folder.string(), "", "a folder that nobody else writes",
                     "one that is being written; wait for that, or stop it");
}

}  // namespace equilux
