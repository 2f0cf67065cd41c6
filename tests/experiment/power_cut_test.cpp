// kill -9 leaves what the system was told; a power cut leaves what was synced. The log is cut at every change
// it makes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "base/error.h"
#include "experiment/trial_log.h"
#include "tests/experiment/crashed_disk.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/old_log.h"
#include "tests/experiment/recording_vfs.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

constexpr std::int64_t kSessionBegun = -1, kSessionFinished = -2;  ///< promises; others are answers, by trial

// A PRAGMA given to each connection behind the log's back, after it has set its own.
class Meddler {
 public:
  Meddler() { sqlite3_auto_extension(reinterpret_cast<void (*)()>(&meet)); }
  ~Meddler() { sqlite3_cancel_auto_extension(reinterpret_cast<void (*)()>(&meet)); }
  static void set(const std::string& pragma) {
    EQ_CHECK(sqlite3_exec(latest_, ("PRAGMA " + pragma).c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  }

 private:
  static int meet(sqlite3* database, char**, const void*) {
    latest_ = database;
    return SQLITE_OK;
  }
  inline static sqlite3* latest_ = nullptr;
};

// A session with an interruption: its log is opened twice, so that a checkpoint comes in its middle and at
// its end.
void run_session(const fs::path& path, RecordingVfs& disk, int trials, const std::string& pragma = "") {
  const Meddler meddler;
  const auto sit = [&](int from, int to) {
    TrialLog log(path, true);
    if (!pragma.empty()) Meddler::set(pragma);
    if (from == 0) {
      log.append_session(make_fake_session(), make_fake_trials(trials));
      disk.promise(kSessionBegun);
    }
    log.append_showing(1, from, 1);
    for (int trial = from; trial < to; ++trial) {
      const auto next = trial + 1 < trials ? std::optional(trial + 1) : std::nullopt;
      log.append_answer(1, {trial, Side::kLeft, 1000}, next, trial);
      disk.promise(trial);
    }
    if (to < trials) return;
    log.finish_session(1, 9);
    disk.promise(kSessionFinished);
  };
  sit(0, trials / 2);
  sit(trials / 2, trials);
}

std::optional<TrialLog> open_if_log(const fs::path& path, bool create) {
  try {
    return TrialLog(path, create);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// The rule: what was promised is there, and at most one answer more.
std::vector<std::string> check_promises(const fs::path& path, const std::set<std::int64_t>& promised) {
  if (promised.empty() && !fs::exists(path)) return {};
  const auto found = open_if_log(path, promised.empty());
  if (!found) return {"lost the log"};
  const TrialLog& log = *found;
  const auto sessions = log.load_sessions();
  std::vector<std::string> breaches;
  if (promised.contains(kSessionBegun) && sessions.empty()) return {"lost the session"};
  if (promised.contains(kSessionFinished) && !sessions.at(0).complete) breaches.push_back("lost the end");
  std::size_t answered = 0, kept = 0;
  for (const TrialRow& trial : log.load_trials(1)) {
    if (trial.answer) ++answered;
    if (!promised.contains(trial.number)) continue;
    ++kept;
    if (!trial.answer) breaches.push_back(fmt::format("lost answer {}", trial.number));
  }
  if (answered > kept + 1) breaches.push_back(fmt::format("{} answers, {} promised", answered, kept));
  return breaches;
}

class PowerCut : public ::testing::Test {
 protected:
  struct Result {
    int cuts = 0;
    std::vector<std::string> breaches;
  };

  // Cuts the power before each of the steps that `is_tried`, and after the last.
  Result cut_at(const std::vector<DiskStep>& steps, const std::function<bool(std::size_t)>& is_tried,
                std::initializer_list<Unsynced> policies) {
    CrashedDisk disk(before_.path());
    std::set<std::int64_t> promised;
    RandomStream random(71, "power cut", 0);
    Result result;
    for (std::size_t step = 0; step <= steps.size(); ++step) {
      for (const Unsynced unsynced : policies) {
        if (!is_tried(step)) break;
        disk.leave(after_.path(), unsynced, random);
        ++result.cuts;
        for (const std::string& breach : check_promises(after_.path() / path_.filename(), promised))
          result.breaches.push_back(fmt::format("cut at step {}: {}", step, breach));
      }
      if (step == steps.size()) break;
      disk.take(steps[step]);
      if (steps[step].kind == DiskStep::kPromise) promised.insert(steps[step].offset);
    }
    return result;
  }
  std::vector<DiskStep> record_session(int trials, const std::string& pragma = "") {
    RecordingVfs disk;
    run_session(path_, disk, trials, pragma);
    return disk.steps();
  }

  // A disk that fails from a step on: what was done, and whether the session stopped with a StoreError.
  std::pair<std::vector<DiskStep>, bool> record_failing_session(std::size_t step, int code) {
    for (const auto& entry : fs::directory_iterator(live_.path())) fs::remove(entry);
    RecordingVfs disk;
    disk.fail_from(step, code);
    try {
      run_session(path_, disk, 8);
    } catch (const StoreError& error) {
      EXPECT_THAT(error.what(), StartsWith(path_.string()));
      return {disk.steps(), true};
    }
    return {disk.steps(), false};
  }

  TemporaryFolder before_, live_, after_;  ///< before_ stays empty
  fs::path path_ = live_.path() / "responses.sqlite";
};

std::size_t count_kind(const std::vector<DiskStep>& steps, DiskStep::Kind kind) {
  return static_cast<std::size_t>(
      std::count_if(steps.begin(), steps.end(), [&](const DiskStep& step) { return step.kind == kind; }));
}

// Seed 71: the sectors that a torn write leaves. All steps of a session of 12 trials, opened twice.
TEST_F(PowerCut, LosesNoPromisedAnswerAtAnyWriteOrSync) {
  const auto steps = record_session(12);
  ASSERT_GE(count_kind(steps, DiskStep::kSync), 14u) << "a sync for each promise, or the recording saw none";
  ASSERT_EQ(count_kind(steps, DiskStep::kPromise), 14u);
  const Result result =
      cut_at(steps, [](std::size_t) { return true; }, {Unsynced::kLost, Unsynced::kKept, Unsynced::kTorn});
  RecordProperty("cuts", result.cuts);
  EXPECT_GE(result.cuts, 300);
  EXPECT_THAT(result.breaches, IsEmpty());
}

// Seed 71. 400 trials: the WAL passes 1,000 pages, so that SQLite checkpoints by itself in mid-session. Cut
// around everything that touches the database file itself, and at every 97th step.
TEST_F(PowerCut, LosesNoPromisedAnswerAroundACheckpointInMidSession) {
  const auto steps = record_session(400);
  std::set<std::size_t> tried;
  for (std::size_t step = 0; step < steps.size(); ++step) {
    const bool is_file = steps[step].path == path_.string();
    if (step % 97 == 0 || (is_file && (steps[step].kind == DiskStep::kSync || step % 5 == 0)))
      tried.insert({step, step + 1});
  }
  const Result result = cut_at(steps, [&](std::size_t step) { return tried.contains(step); },
                               {Unsynced::kLost, Unsynced::kTorn});
  RecordProperty("cuts", result.cuts);
  EXPECT_GE(result.cuts, 100);
  EXPECT_THAT(result.breaches, IsEmpty());
}

// Counts how often SQLite's own VFS opens a folder, which it does to sync it.
class FolderSyncs {
 public:
  FolderSyncs() : vfs_(sqlite3_vfs_find(nullptr)) {
    original_ = reinterpret_cast<OpenFolder*>(vfs_->xGetSystemCall(vfs_, kName));
    count_ = 0;
    vfs_->xSetSystemCall(vfs_, kName, reinterpret_cast<sqlite3_syscall_ptr>(&open));
  }
  ~FolderSyncs() { vfs_->xSetSystemCall(vfs_, kName, nullptr); }
  std::size_t count() const { return count_; }

 private:
  using OpenFolder = int(const char*, int*);
  static constexpr const char* kName = "openDirectory";
  static int open(const char* file, int* descriptor) {
    ++count_;
    return original_(file, descriptor);
  }
  inline static OpenFolder* original_ = nullptr;
  inline static std::size_t count_ = 0;
  sqlite3_vfs* vfs_;
};

// Seed 71. A log of schema 1 with three answers is brought up; a copy is kept first, and may be left
// unfinished.
TEST_F(PowerCut, LeavesALogOfAnOlderSchemaOrTheNewOneWhole) {
  make_old_log(path_);
  CrashedDisk disk(live_.path());
  std::vector<DiskStep> steps;
  {
    RecordingVfs recording;
    TrialLog{path_};
    steps = recording.steps();
  }
  ASSERT_GE(steps.size(), 50u);
  RandomStream random(71, "power cut", 1);
  for (std::size_t step = 0; step <= steps.size(); ++step) {
    for (const Unsynced unsynced : {Unsynced::kLost, Unsynced::kKept, Unsynced::kTorn}) {
      disk.leave(after_.path(), unsynced, random);
      const TrialLog log(after_.path() / path_.filename());
      ASSERT_EQ(log.load_sessions().size(), 2u) << step;
      ASSERT_EQ(log.load_events(2).size(), 1u) << step;
      ASSERT_TRUE(log.load_trials(1).at(1).answer) << step;
    }
    if (step < steps.size()) disk.take(steps[step]);
  }
}

// What the crashed disk takes for granted of SQLite: the answers in a new WAL would else be lost with its
// name.
TEST_F(PowerCut, FoldersAreSyncedAsOftenAsTheRecordingSays) {
  const FolderSyncs syncs;
  const auto steps = record_session(12);
  const auto said =
      std::count_if(steps.begin(), steps.end(), [](const DiskStep& step) { return step.syncs_folder; });
  EXPECT_GE(said, 3) << "a journal and two WALs";
  EXPECT_EQ(syncs.count(), static_cast<std::size_t>(said));
}

// Mutants: SQLite in its faster settings. The check must see answers lost, where kill -9 would lose none.
TEST_F(PowerCut, IsSeenByItsCheckWhenTheLogIsNotFullySynced) {
  for (const char* pragma : {"synchronous = NORMAL", "synchronous = OFF"}) {
    for (const auto& entry : fs::directory_iterator(live_.path())) fs::remove(entry);
    const auto steps = record_session(12, pragma);
    const auto is_tried = [](std::size_t) { return true; };
    EXPECT_THAT(cut_at(steps, is_tried, {Unsynced::kLost}).breaches, Contains(HasSubstr(": lost ")))
        << pragma;
    EXPECT_THAT(cut_at(steps, is_tried, {Unsynced::kKept}).breaches, IsEmpty()) << pragma;
  }
}

// Mutant: an answer is promised before it is committed.
TEST_F(PowerCut, IsSeenByItsCheckWhenAnAnswerIsPromisedTooSoon) {
  auto steps = record_session(12);
  for (std::size_t step = steps.size() - 1; step > 0; --step) {
    if (steps[step].kind == DiskStep::kPromise && steps[step].offset == 3)
      std::swap(steps[step], steps[step - 1]);
  }
  EXPECT_THAT(cut_at(steps, [](std::size_t) { return true; }, {Unsynced::kLost}).breaches,
              Contains(HasSubstr("lost answer 3")));
}

// A disk that fails at any change and ever after: the session stops, and a power cut then loses nothing
// either.
TEST_F(PowerCut, AfterAFailureOfTheDiskLosesNothing) {
  const std::size_t count = record_session(8).size();
  int stopped = 0;
  constexpr int kCodes[] = {SQLITE_FULL, SQLITE_IOERR_WRITE, SQLITE_IOERR_FSYNC};
  for (std::size_t step = 0; step < count; ++step) {
    const auto [steps, threw] = record_failing_session(step, kCodes[step % std::size(kCodes)]);
    if (threw) ++stopped;
    const bool finished = std::any_of(steps.begin(), steps.end(), [](const DiskStep& done) {
      return done.kind == DiskStep::kPromise && done.offset == kSessionFinished;
    });
    EXPECT_TRUE(threw || finished) << "step " << step << ": went on without a disk";
    const std::size_t end = steps.size();
    const Result result =
        cut_at(steps, [&](std::size_t at) { return at == end; }, {Unsynced::kLost, Unsynced::kKept});
    EXPECT_THAT(result.breaches, IsEmpty()) << "failed from step " << step;
  }
  RecordProperty("stopped", stopped);
  EXPECT_GE(stopped, 100);
}

}  // namespace
}  // namespace equilux
