// An advisory lock of the system on a file of its own.
#include "base/folder_lock.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "base/work_control.h"

namespace equilux {
namespace {

constexpr std::size_t kMostBytes = 300;

std::string tell_holder() { return fmt::format("process {} on {}", ::getpid(), find_host_name()); }

// For messages alone: a disk without room for it keeps two programs apart all the same.
void write_holder(int descriptor, const std::string& holder) {
  const std::string line = holder + "\n";
  if (::pwrite(descriptor, line.data(), line.size(), 0) < 0) return;
  if (::ftruncate(descriptor, static_cast<off_t>(line.size())) != 0) return;
}

void erase_holder(int descriptor) {
  if (::ftruncate(descriptor, 0) != 0) return;
}

// Empty where what stands there is no line that can be printed.
std::string read_holder(int descriptor) {
  char buffer[kMostBytes];
  const ssize_t size = ::pread(descriptor, buffer, sizeof buffer, 0);
  if (size <= 0) return "";
  const std::string text(buffer, static_cast<std::size_t>(size));
  const std::string line = text.substr(0, text.find('\n'));
  const auto is_printable = [](char c) { return c >= 32 && c < 127; };
  return line != text && std::all_of(line.begin(), line.end(), is_printable) ? line : "";
}

// What is locked no longer stands under its name: the folder was moved or removed after it was opened.
bool is_moved(int descriptor, const std::filesystem::path& path) {
  struct stat locked, named;
  return ::fstat(descriptor, &locked) != 0 || ::stat(path.c_str(), &named) != 0 ||
         locked.st_ino != named.st_ino || locked.st_dev != named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) : path_(folder / ".lock") {
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw StoreError(fmt::format("{}: cannot open: {}", path_.string(), std::strerror(errno)));
  int result = 0;
  do {
    result = ::flock(descriptor_, LOCK_EX | LOCK_NB);
  } while (result != 0 && errno == EINTR);
  if (result != 0 && errno != EWOULDBLOCK) {
    const std::string why = std::strerror(errno);
    ::close(descriptor_);
    throw StoreError(
        fmt::format("{}: cannot be locked: {}; a folder is written where the file system keeps two programs "
                    "apart",
                    path_.string(), why));
  }
  busy_ = result != 0 || is_moved(descriptor_, path_);
  if (result != 0) holder_ = read_holder(descriptor_);
  if (!busy_) write_holder(descriptor_, tell_holder());
}

FolderLock::~FolderLock() {
  if (!busy_) erase_holder(descriptor_);
  ::close(descriptor_);
}

std::unique_ptr<FolderLock> lock_folder(const std::filesystem::path& folder,
                                        std::chrono::milliseconds patience) {
  const auto until = std::chrono::steady_clock::now() + patience;
  while (true) {
    make_folder(folder);
    auto lock = std::make_unique<FolderLock>(folder);
    if (!lock->is_busy()) return lock;
    if (std::chrono::steady_clock::now() >= until)
      throw InputError(
          folder.string(), "", "a folder that nobody else writes",
          fmt::format("one that {}; wait for that, or stop it",
                      lock->holder().empty() ? "is being written" : lock->holder() + " is writing"));
    lock.reset();
    check_control();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace equilux
