// kill -9 in mid-session: what was acknowledged is on the disk, and the session goes on where it was.
#include <chrono>
#include <cstdlib>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/random.h"
#include "experiment/trial_log.h"
#include "tests/experiment/child.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;

constexpr int kKills = 20;
constexpr int kSubjectsPerKill =
    12;  ///< more trials than a run can do: 64 heard, 4,096 bytes of lines unread
constexpr int kTrials = 32;

using TrialName = std::pair<std::int64_t, int>;  ///< session, trial

std::set<TrialName> load_answered(const TrialLog& log) {
  std::set<TrialName> answered;
  for (const SessionRow& row : log.load_sessions()) {
    for (const TrialRow& trial : log.load_trials(row.id)) {
      if (trial.answer) answered.emplace(row.id, trial.number);
    }
  }
  return answered;
}

/// The rule: everything acknowledged is answered, and at most one answer was committed without being heard
/// of.
std::vector<std::string> check_kept(const std::set<TrialName>& acknowledged,
                                    const std::set<TrialName>& answered) {
  std::vector<std::string> breaches;
  for (const auto& [session, trial] : acknowledged) {
    if (!answered.contains({session, trial})) breaches.push_back(fmt::format("lost {} {}", session, trial));
  }
  if (answered.size() > acknowledged.size() + 1) {
    breaches.push_back(fmt::format("{} answers, but {} acknowledged", answered.size(), acknowledged.size()));
  }
  return breaches;
}

std::optional<TrialName> parse_acknowledgement(const std::string& line) {
  long session = 0;
  int trial = 0;
  if (std::sscanf(line.c_str(), "answered %ld %d", &session, &trial) != 2) return std::nullopt;
  return TrialName{session, trial};
}

class Kill : public ::testing::Test {
 protected:
  std::vector<std::string> arguments(const StudyFolder& folder) const {
    return {"simulate",     folder.root.string(),      "--experiment", "artifact",
            "--subjects",   std::to_string(subjects_), "--seed",       "8",
            "--acknowledge"};
  }

  // Reads a random number of acknowledgements, waits a moment, halts, and kills if that was in mid-session:
  // else it lets go on to the next session, in which another moment comes. Gives how many came in this run.
  int run_and_kill(RandomStream& random) {
    Child child(kSessionProgram, arguments(folder_));
    const auto wanted = static_cast<int>(1 + random.next_below(2 * kTrials));
    int heard = 0;
    bool is_halted = false;
    do {
      if (is_halted) child.go_on();
      do {
        const auto line = child.read_line();
        if (!line) break;
        hear(*line, heard);
      } while (heard < wanted);
      std::this_thread::sleep_for(std::chrono::microseconds(random.next_below(300)));
      is_halted = child.stop();
      while (const auto line = child.read_ready_line()) hear(*line, heard);
    } while (is_halted && last_trial_ == kTrials - 1);
    child.kill();
    while (const auto line = child.read_line()) hear(*line, heard);  // said before the kill
    EXPECT_EQ(child.wait().signal, SIGKILL) << "the program was over before it was killed";
    return heard;
  }
  void hear(const std::string& line, int& heard) {
    const auto name = parse_acknowledgement(line);
    ASSERT_TRUE(name) << line;
    EXPECT_TRUE(acknowledged_.insert(*name).second) << "answered twice: " << line;
    last_trial_ = name->second;
    ++heard;
  }

  void kill_again_and_again(int kills) {
    subjects_ = kills * kSubjectsPerKill;
    RandomStream random(41, "kill", 0);
    int in_mid_session = 0;
    for (int kill = 0; kill < kills; ++kill) {
      const int heard = run_and_kill(random);
      EXPECT_GE(heard, 1) << "a kill before the first acknowledgement shows nothing";
      const TrialLog log(folder_.responses());
      const auto answered = load_answered(log);
      ASSERT_THAT(check_kept(acknowledged_, answered), IsEmpty()) << "kill " << kill;
      ASSERT_LT(answered.size(), static_cast<std::size_t>(subjects_) * kTrials)
          << "a kill after the last shows nothing";
      if (answered.size() % kTrials != 0) ++in_mid_session;
      acknowledged_ = answered;  // one may have been committed unheard; the next run will not say it
    }
    RecordProperty("kills_in_mid_session", in_mid_session);
    EXPECT_GE(in_mid_session, kills / 2) << "kills must fall between acknowledgements of one session";
    check_end(kills, in_mid_session);
  }

  // Gone on with to the end, the log is that of a study which nobody disturbed.
  void check_end(int kills, int in_mid_session) {
    EXPECT_EQ(Child(kSessionProgram, arguments(folder_)).wait().exit_code, 0);
    EXPECT_EQ(Child(kSessionProgram, arguments(undisturbed_)).wait().exit_code, 0);
    EXPECT_EQ(load_shared_content(folder_.responses()), load_shared_content(undisturbed_.responses()));
    const RawDatabase database(folder_.responses());
    EXPECT_EQ(database.value("SELECT count(*) FROM session WHERE complete = 1"), std::to_string(subjects_));
    const int resumed = std::stoi(database.value("SELECT count(*) FROM event WHERE kind = 'resume'"));
    EXPECT_GE(resumed, in_mid_session);
    EXPECT_LE(resumed, kills);
  }

  int subjects_ = kKills * kSubjectsPerKill;
  TemporaryFolder first_, second_;
  StudyFolder folder_ = make_fake_study(first_.path());
  StudyFolder undisturbed_ = make_fake_study(second_.path());
  std::set<TrialName> acknowledged_;
  int last_trial_ = -1;  ///< that was acknowledged
};

// Seed 41: after 1 to 64 acknowledgements and 0 to 0.3 ms more, 20 times, in 240 sessions of 32 trials.
TEST_F(Kill, LosesNoAcknowledgedAnswerAtTwentyMoments) { kill_again_and_again(kKills); }

// By hand (some minutes): the same 200 times in 2,400 sessions, or as often as EQUILUX_KILLS says.
TEST_F(Kill, DISABLED_LosesNoAcknowledgedAnswerAtTwoHundredMoments) {
  const char* asked = std::getenv("EQUILUX_KILLS");
  kill_again_and_again(asked ? std::stoi(asked) : 200);
}

// Mutant: one acknowledged answer is taken out of the log. The check must say so.
TEST_F(Kill, IsSeenByItsCheckWhenAnAnswerIsDropped) {
  RandomStream random(42, "kill", 0);
  run_and_kill(random);
  const TrialName victim = *acknowledged_.begin();
  RawDatabase(folder_.responses())
      .query(fmt::format("UPDATE trial SET answer = NULL, response_time_ns = NULL, answered_utc = NULL"
                         " WHERE session = {} AND trial = {}",
                         victim.first, victim.second));
  const auto breaches = check_kept(acknowledged_, load_answered(TrialLog(folder_.responses())));
  EXPECT_THAT(breaches, Contains(fmt::format("lost {} {}", victim.first, victim.second)));
}

// Mutant: answers are acknowledged late. The check must say so.
TEST_F(Kill, IsSeenByItsCheckWhenAcknowledgementsLag) {
  EXPECT_THAT(check_kept({{1, 0}}, {{1, 0}, {1, 1}}), IsEmpty());
  EXPECT_EQ(check_kept({{1, 0}}, {{1, 0}, {1, 1}, {1, 2}}).size(), 1u);
}

}  // namespace
}  // namespace equilux
