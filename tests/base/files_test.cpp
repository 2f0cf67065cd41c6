// Files appear under their name only when whole, whatever fails on the way.
#include "base/files.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/error.h"
#include "base/program.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

TEST(SaveText, RoundTripsAndLeavesNothingBeside) {
  const TempFolder folder;
  const std::string text("line\nzero \0 byte\r\n", 18);
  save_text(folder / "a.txt", text);
  EXPECT_EQ(load_text(folder / "a.txt"), text);
  save_text(folder / "a.txt", "");
  EXPECT_EQ(load_text(folder / "a.txt"), "");
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(SaveText, ThatRunsOutOfSpaceLeavesNothing) {
  const TempFolder folder;
  const auto path = folder / "a.txt";
  std::string message;
  {
    const FileSizeLimit limit(1000);
    message = message_of<StoreError>([&] { save_text(path, std::string(5000, 'x')); });
  }
  EXPECT_THAT(message, HasSubstr(path.string()));
  EXPECT_EQ(folder.entry_count(), 0);
}

TEST(SaveText, ThatRunsOutOfSpaceKeepsTheOldFile) {
  const TempFolder folder;
  folder.write("a.txt", "old");
  {
    const FileSizeLimit limit(1000);
    EXPECT_THROW(save_text(folder / "a.txt", std::string(5000, 'x')), StoreError);
  }
  EXPECT_EQ(load_text(folder / "a.txt"), "old");
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(SaveText, IntoAMissingFolderIsAStoreErrorThatNamesThePath) {
  const TempFolder folder;
  const auto path = folder / "missing/a.txt";
  EXPECT_THAT(message_of<StoreError>([&] { save_text(path, "x"); }), HasSubstr(path.string()));
  EXPECT_EQ(folder.entry_count(), 0);
}

TEST(SaveText, OverAFolderIsAStoreErrorAndLeavesNoTemporary) {
  const TempFolder folder;
  folder.write("a/inner", "kept");
  EXPECT_THAT(message_of<StoreError>([&] { save_text(folder / "a", "x"); }),
              HasSubstr("a: cannot write: expected a regular file"));
  EXPECT_EQ(load_text(folder / "a/inner"), "kept");
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(SaveText, NeverReplacesWhatIsNoRegularFile) {
  const TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(save_text(folder / "pipe", "x"), StoreError);
  EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
}

TEST(CheckWritable, RefusesFoldersPipesAndMissingParentsBeforeTheWork) {
  const TempFolder folder;
  folder.write("file", "x");
  EXPECT_NO_THROW(check_writable(folder / "file"));
  EXPECT_NO_THROW(check_writable(folder / "new"));
  EXPECT_THROW(check_writable(folder.path()), InputError);
  EXPECT_THROW(check_writable(folder / "missing/new"), InputError);
  EXPECT_THROW(check_writable(""), InputError);
}

TEST(SaveAtomically, ThatIsInterruptedByAnExceptionLeavesNothing) {
  const TempFolder folder;
  const auto write = [](const std::filesystem::path& temporary) {
    std::ofstream(temporary) << "half";
    throw std::runtime_error("stop");
  };
  EXPECT_THROW(save_atomically(folder / "a", write), std::runtime_error);
  EXPECT_EQ(folder.entry_count(), 0);
}

TEST(SaveAtomically, WithoutAFileBeingWrittenIsAStoreError) {
  const TempFolder folder;
  EXPECT_THROW(save_atomically(folder / "a", [](const std::filesystem::path&) {}), StoreError);
  EXPECT_EQ(folder.entry_count(), 0);
}

TEST(LoadText, RefusesMoreThanItsBoundAndTakesExactlyIt) {
  const TempFolder folder;
  const auto path = folder.write("a", std::string(1000, 'x'));
  EXPECT_EQ(load_text(path, 1000).size(), 1000u);
  EXPECT_THAT(message_of<InputError>([&] { load_text(path, 999); }),
              AllOf(HasSubstr(path.string()), HasSubstr("at most 999 bytes")));
}

TEST(LoadText, RefusesAPipeWithoutWaitingAndADeviceWithoutEnd) {
  const TempFolder folder;
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  for (const std::filesystem::path& path : {folder / "pipe", std::filesystem::path("/dev/zero")}) {
    EXPECT_THAT(message_of<InputError>([&] { load_text(path); }),
                AllOf(HasSubstr(path.string()), HasSubstr("expected a regular file, got another kind")));
  }
}

TEST(LoadText, NamesAMissingFileAndAFolder) {
  const TempFolder folder;
  const auto missing = folder / "missing";
  EXPECT_THAT(message_of<InputError>([&] { load_text(missing); }),
              AllOf(HasSubstr(missing.string()), HasSubstr("No such file")));
  EXPECT_THAT(message_of<InputError>([&] { load_text(folder.path()); }),
              AllOf(HasSubstr(folder.path().string()), HasSubstr("got a folder")));
}

TEST(RemoveStaleParts, TakesWhatEndedWritersLeftAndNothingElse) {
  const TempFolder folder;
  const pid_t ended = ::fork();
  if (ended == 0) ::_exit(0);
  ASSERT_EQ(::waitpid(ended, nullptr, 0), ended);
  const std::string host = find_host_name();
  const auto stale = folder.write(fmt::format("a.json.{}@{}.part", ended, host), "half");
  folder.write(fmt::format("a.json.{}@{}.part", ::getpid(), host), "being written");
  // Another machine's process of that number may well run.
  folder.write(fmt::format("a.json.{}@elsewhere.org.part", ended), "being written");
  const auto old = folder.write(fmt::format("b.json.{}@elsewhere.org.part", ended), "half");
  std::filesystem::last_write_time(old,
                                   std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
  for (const std::string& name :
       {std::string("a.json"), std::string("notes.part"), "a.json.@" + host + ".part",
        "a.json.12x@" + host + ".part", "a.json.-7@" + host + ".part", "7@" + host + ".part",
        std::string("a.json.12@.part"), std::string("@.part")})
    folder.write(name, "a person's own");
  remove_stale_parts(folder.path());
  EXPECT_EQ(folder.entry_count(), 10);
  EXPECT_FALSE(std::filesystem::exists(stale));
  EXPECT_FALSE(std::filesystem::exists(old));
  remove_stale_parts(folder / "nowhere");
}

TEST(MakeFolder, MakesParentsAndTakesOneThatIsThere) {
  const TempFolder folder;
  make_folder(folder / "a/b/c");
  make_folder(folder / "a/b/c");
  EXPECT_TRUE(std::filesystem::is_directory(folder / "a/b/c"));
}

TEST(MakeFolder, WhereAFileStandsIsAStoreErrorThatNamesIt) {
  const TempFolder folder;
  folder.write("a", "file");
  EXPECT_THAT(message_of<StoreError>([&] { make_folder(folder / "a/b"); }), HasSubstr("/a/b: "));
  EXPECT_THAT(message_of<StoreError>([&] { make_folder(folder / "a"); }),
              HasSubstr("/a: cannot make the folder: a file has that name"));
}

}  // namespace
}  // namespace equilux
