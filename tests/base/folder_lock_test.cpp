// One writer, also where the file system fails to say so.
#include "base/folder_lock.h"

#include <cerrno>
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include "base/error.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace {

// What the next calls of flock fail with, where not 0, and how many of them.
int failing_errno = 0, failing_calls = 0;

}  // namespace

// In this program in place of the system's, which it calls unless a test makes it fail.
extern "C" int flock(int descriptor, int operation) noexcept {
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

TEST(FolderLock, IsBusyWhileAnotherHoldsIt) {
  const TempFolder folder;
  {
    const FolderLock lock(folder.path());
    EXPECT_FALSE(lock.is_busy());
    EXPECT_TRUE(FolderLock(folder.path()).is_busy());
    EXPECT_THROW(check_not_busy(FolderLock(folder.path()), folder.path()), InputError);
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

}  // namespace
}  // namespace equilux
