// A lock of the system on a byte, by open file and not by process: closing another file lets go of nothing.
#include "experiment/session_lock.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

#include "base/digest.h"
#include "base/error.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kPlaceDigits = 15;  // of a file's length, which is below 2^63

fs::path lock_of(const fs::path& log) { return log.string() + ".lock"; }

// Whoever may write the log may take its lock, of a shared log the group too; as far as this user can say so.
void share_like_log(int descriptor, const fs::path& log) {
  struct stat of_log {
  }, of_lock{};
  if (::stat(log.c_str(), &of_log) != 0 || ::fstat(descriptor, &of_lock) != 0) return;
  const mode_t mode = 0600 | (of_log.st_mode & 0060);
  if (of_lock.st_uid != ::geteuid()) return;
  if (of_lock.st_gid != of_log.st_gid && ::fchown(descriptor, static_cast<uid_t>(-1), of_log.st_gid) != 0)
    return;
  if ((of_lock.st_mode & 0777) != mode) ::fchmod(descriptor, mode);
}

struct flock find_place(const std::string& session, short type) {
  struct flock place {};
  place.l_type = type;
  place.l_whence = SEEK_SET;
  place.l_start = std::stoll(digest_text(session).substr(0, kPlaceDigits), nullptr, 16);
  place.l_len = 1;
  return place;
}

[[noreturn]] void fail(const fs::path& path, const char* what) {
  throw StoreError(fmt::format("{}: {}: {}; without it two windows could run one session, and spoil it",
                               path.string(), what, std::strerror(errno)));
}

}  // namespace

SessionLock::SessionLock(const fs::path& log, const std::string& session) {
  const fs::path path = lock_of(log);
  descriptor_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (descriptor_ < 0) fail(path, "cannot be opened");
  share_like_log(descriptor_, log);
  struct flock place = find_place(session, F_WRLCK);
  if (::fcntl(descriptor_, F_OFD_SETLK, &place) == 0) return;
  is_busy_ = errno == EAGAIN || errno == EACCES;
  const int cause = errno;
  ::close(std::exchange(descriptor_, -1));
  errno = cause;
  if (!is_busy_) fail(path, "cannot be locked");
}

SessionLock::~SessionLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

SessionLock::SessionLock(SessionLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), is_busy_(other.is_busy_) {}

SessionLock& SessionLock::operator=(SessionLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(is_busy_, other.is_busy_);
  return *this;
}

bool SessionLock::is_held(const fs::path& log, const std::string& session) {
  const int descriptor = ::open(lock_of(log).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  struct flock place = find_place(session, F_RDLCK);
  const bool is_known = ::fcntl(descriptor, F_OFD_GETLK, &place) == 0;
  ::close(descriptor);
  return is_known && place.l_type != F_UNLCK;
}

}  // namespace equilux
