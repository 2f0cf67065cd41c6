// A session that another program runs, and one whose program was killed.
#include "experiment/session_lock.h"

#include <csignal>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/error.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr const char* kSession = "person/artifact/P01";

// A process that takes the lock and does nothing more.
class Holder {
 public:
  explicit Holder(const std::filesystem::path& log) {
    int ready[2];
    EQ_CHECK(::pipe(ready) == 0);
    pid_ = ::fork();
    EQ_CHECK(pid_ >= 0);
    if (pid_ == 0) {
      const SessionLock lock(log, kSession);
      const char answer = lock.is_busy() ? 'b' : 'h';
      if (::write(ready[1], &answer, 1) != 1) ::_exit(1);
      for (;;) ::pause();
    }
    ::close(ready[1]);
    EQ_CHECK(::read(ready[0], &answer_, 1) == 1);
    ::close(ready[0]);
  }
  ~Holder() {
    if (pid_ > 0) kill();
  }
  Holder(const Holder&) = delete;
  Holder& operator=(const Holder&) = delete;

  bool has_it() const { return answer_ == 'h'; }
  void kill() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
  char answer_ = 0;
};

class SessionLockTest : public testing::Test {
 protected:
  TempFolder folder_;
  std::filesystem::path log_ = folder_ / "responses.sqlite";
};

TEST_F(SessionLockTest, IsHeldByOneProgramUntilThatIsKilled) {
  Holder holder(log_);
  ASSERT_TRUE(holder.has_it());
  EXPECT_TRUE(SessionLock::is_held(log_, kSession));
  EXPECT_TRUE(SessionLock(log_, kSession).is_busy());
  EXPECT_TRUE(SessionLock(log_, kSession).is_busy()) << "asking takes nothing from its holder";
  holder.kill();
  EXPECT_FALSE(SessionLock::is_held(log_, kSession));
  const SessionLock lock(log_, kSession);
  EXPECT_FALSE(lock.is_busy());
  EXPECT_FALSE(Holder(log_).has_it());
}

TEST_F(SessionLockTest, OtherSessionsOfTheLogAreFree) {
  const SessionLock lock(log_, kSession);
  for (const char* other : {"person/artifact/P02", "person/material/P01", "planted/artifact/P01"}) {
    EXPECT_FALSE(SessionLock::is_held(log_, other)) << other;
    EXPECT_FALSE(SessionLock(log_, other).is_busy()) << other;
  }
  EXPECT_FALSE(SessionLock(folder_ / "another.sqlite", kSession).is_busy());
}

TEST_F(SessionLockTest, GoesWithWhoTakesItOver) {
  SessionLock first(log_, kSession);
  {
    const SessionLock second = std::move(first);
    EXPECT_TRUE(SessionLock::is_held(log_, kSession));
  }
  EXPECT_FALSE(SessionLock::is_held(log_, kSession));
}

// Who withdraws must not be found in it.
TEST_F(SessionLockTest, WritesNobodysCodeAndMakesNoFileForWhoAsks) {
  EXPECT_FALSE(SessionLock::is_held(log_, kSession));
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
  const SessionLock lock(log_, kSession);
  EXPECT_EQ(std::filesystem::file_size(folder_ / "responses.sqlite.lock"), 0U);
  EXPECT_EQ(std::filesystem::status(folder_ / "responses.sqlite.lock").permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

// Of a log that a group may write each of the group takes the lock in turn.
TEST_F(SessionLockTest, MayBeTakenByWhoMayWriteTheLog) {
  namespace fs = std::filesystem;
  const fs::path lock = folder_ / "responses.sqlite.lock";
  folder_.write("responses.sqlite", "");
  for (const unsigned mode : {0660U, 0640U, 0600U, 0664U}) {
    fs::permissions(log_, static_cast<fs::perms>(mode));
    EXPECT_FALSE(SessionLock(log_, kSession).is_busy());
    EXPECT_EQ(fs::status(lock).permissions(), static_cast<fs::perms>(mode & 0660U));
  }
}

TEST_F(SessionLockTest, SaysWhereItCannotBeMade) {
  EXPECT_THAT([&] { SessionLock(folder_ / "missing/log", kSession); },
              ThrowsMessage<StoreError>(HasSubstr("missing/log.lock: cannot be opened: No such file")));
}

}  // namespace
}  // namespace equilux
