// One writer, also where the file system fails to say so.
#include "base/folder_lock.h"

#include <cerrno>
#include <dlfcn.h>
#include <fmt/format.h>
#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <thread>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "base/work_control.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace {

// What the next calls of flock fail with, where not 0, and how many of them.
int failing_errno = 0, failing_calls = 0;

// What happens between the opening of a lock's file and its locking, the next time.
std::function<void()> before_locking;

}  // namespace

// In this program in place of the system's, which it calls unless a test makes it fail.
extern "C" int flock(int descriptor, int operation) noexcept {
  if (const auto act = std::exchange(before_locking, nullptr)) act();
  if (failing_calls > 0) {
    --failing_calls;
    errno = failing_errno;
    return -1;
  }
  using Flock = int (*)(int, int);
  static const auto real = reinterpret_cast<Flock>(dlsym(RTLD_NEXT, "flock"));
  return real(descriptor, operation);
}

namespace equilux {
namespace {
using std::chrono::milliseconds;
using testing::HasSubstr;

TEST(FolderLock, IsBusyWhileAnotherHoldsIt) {
  const TempFolder folder;
  {
    const FolderLock lock(folder.path());
    EXPECT_FALSE(lock.is_busy());
    EXPECT_TRUE(FolderLock(folder.path()).is_busy());
  }
  EXPECT_FALSE(FolderLock(folder.path()).is_busy());
}

TEST(FolderLock, OfAFileSystemWithoutLocksIsRefused) {
  const TempFolder folder;
  for (const int error : {ENOSYS, EOPNOTSUPP, ENOLCK}) {
    failing_errno = error;
    failing_calls = 1;
    EXPECT_THAT(message_of<StoreError>([&] { FolderLock{folder.path()}; }),
                testing::HasSubstr(".lock: cannot be locked: "));
  }
  EXPECT_FALSE(FolderLock(folder.path()).is_busy()) << "what was refused is not held";
}

TEST(FolderLock, IsAskedForAgainAfterASignal) {
  const TempFolder folder;
  failing_errno = EINTR;
  failing_calls = 3;
  const FolderLock lock(folder.path());
  EXPECT_FALSE(lock.is_busy());
  EXPECT_TRUE(FolderLock(folder.path()).is_busy()) << "it is held";
}

TEST(FolderLock, NamesWhoHoldsItWhileItIsHeld) {
  const TempFolder folder;
  const std::string self = fmt::format("process {} on {}", ::getpid(), find_host_name());
  {
    const FolderLock lock(folder.path());
    EXPECT_EQ(FolderLock(folder.path()).holder(), self);
    EXPECT_EQ(message_of<InputError>([&] { lock_folder(folder.path(), milliseconds(0)); }),
              folder.path().string() + ": expected a folder that nobody else writes, got one that " + self +
                  " is writing; wait for that, or stop it");
    EXPECT_EQ(FolderLock(folder.path()).holder(), self) << "who was refused has erased no name";
  }
  EXPECT_EQ(load_text(folder / ".lock"), "");
}

// A holder that was killed leaves its name, another program's file has anything, a full disk has nothing.
TEST(FolderLock, IsTakenWhateverItsFileHolds) {
  const TempFolder folder;
  for (const std::string text : {"", "process 1 on elsewhere\n", "no end of line", "\x01\xff\n"}) {
    folder.write(".lock", text);
    EXPECT_FALSE(FolderLock(folder.path()).is_busy()) << text;
    const FolderLock lock(folder.path());
    folder.write(".lock", text);
    EXPECT_TRUE(FolderLock(folder.path()).is_busy()) << text;
    EXPECT_EQ(FolderLock(folder.path()).holder(), text.find("process") == 0 ? "process 1 on elsewhere" : "");
    if (text.find("process") != 0) {
      EXPECT_THAT(message_of<InputError>([&] { lock_folder(folder.path(), milliseconds(0)); }),
                  HasSubstr("got one that is being written; wait"));
    }
  }
  const FileSizeLimit full(0);
  const FolderLock lock(folder.path());
  EXPECT_FALSE(lock.is_busy());
  EXPECT_TRUE(FolderLock(folder.path()).is_busy());
}

TEST(FolderLock, IsAskedForAgainWhileSomebodyOnlyLooks) {
  const TempFolder folder;
  auto look = std::make_unique<FolderLock>(folder.path());
  std::thread end([&] {
    std::this_thread::sleep_for(milliseconds(60));
    look.reset();
  });
  std::unique_ptr<FolderLock> lock;
  EXPECT_NO_THROW(lock = lock_folder(folder.path(), milliseconds(60'000)));
  end.join();
  EXPECT_FALSE(!lock || lock->is_busy());
}

TEST(FolderLock, IsWaitedForUntilTheWorkIsCancelled) {
  const TempFolder folder;
  const FolderLock held(folder.path());
  WorkControl control;
  control.cancel();
  const ControlledWork controlled(control);
  EXPECT_THROW(lock_folder(folder.path(), milliseconds(60'000)), WorkCancelled);
}

// Who opened the file before the folder was moved holds a lock that keeps nobody from the folder's name.
TEST(FolderLock, OfAFolderThatWasMovedAwayMeanwhileIsNotTaken) {
  const TempFolder folder;
  const auto share = folder / "share";
  make_folder(share);
  const auto move = [&] { std::filesystem::rename(share, folder / "moved"); };
  before_locking = move;
  EXPECT_TRUE(FolderLock(share).is_busy());
  std::filesystem::rename(folder / "moved", share);
  before_locking = move;
  const auto lock = lock_folder(share, milliseconds(60'000));
  EXPECT_TRUE(FolderLock(share).is_busy()) << "a new folder of that name is locked";
}

}  // namespace
}  // namespace equilux
