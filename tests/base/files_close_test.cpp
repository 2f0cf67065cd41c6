// A file system of the network tells that it is full when a file is closed, and to who wrote it alone.
#include <cerrno>
#include <dlfcn.h>
#include <fcntl.h>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace {

bool fails_to_close = false;  // of regular files
std::vector<int> synced;      // access modes of descriptors of regular files

bool is_regular(int descriptor) {
  struct stat status {};
  return ::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
}

template <typename Function>
Function* find_next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

// In place of the system's, for the whole program.
extern "C" int close(int descriptor) {
  const bool fails = fails_to_close && is_regular(descriptor);
  const int result = find_next<int(int)>("close")(descriptor);
  if (!fails) return result;
  errno = EDQUOT;
  return -1;
}
extern "C" int fsync(int descriptor) {
  if (is_regular(descriptor)) synced.push_back(::fcntl(descriptor, F_GETFL) & O_ACCMODE);
  return find_next<int(int)>("fsync")(descriptor);
}

namespace equilux {
namespace {
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class FullAtClose : public testing::Test {
 protected:
  FullAtClose() {
    folder_.write("a.txt", "old");
    synced.clear();
    fails_to_close = true;
  }
  ~FullAtClose() override { fails_to_close = false; }

  template <typename Save>
  void expect_kept(const Save& save) {
    const std::string message = message_of<StoreError>(save);
    fails_to_close = false;
    EXPECT_THAT(message, AllOf(HasSubstr("a.txt"), HasSubstr("cannot close: Disk quota exceeded")));
    EXPECT_EQ(load_text(folder_ / "a.txt"), "old");
    EXPECT_EQ(folder_.entry_count(), 1);
  }

  const TempFolder folder_;
};

TEST_F(FullAtClose, ATextThatIsSavedIsTheOldOne) {
  expect_kept([&] { save_text(folder_ / "a.txt", "new"); });
  EXPECT_THAT(synced, ElementsAre(O_WRONLY)) << "by the descriptor that wrote";
}

TEST_F(FullAtClose, AFileThatALibraryWritesIsTheOldOne) {
  expect_kept([&] {
    save_atomically(folder_ / "a.txt",
                    [](const std::filesystem::path& part) { std::ofstream(part) << "new"; });
  });
}

}  // namespace
}  // namespace equilux
