// A planted subject in front of the real window: the log of the headless one, and a session as long as the
// paper's.
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/e2e/child_process.h"
#include "tests/e2e/x_display.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using testing::HasSubstr;

constexpr const char* kProtocol = R"({
  "schema": "equilux-session", "schema_version": 1,
  "familiarisation": {"objects": true, "examples": 2, "practice_trials": 3},
  "breaks": {"every_trials": 10}, "catch_trials": {"count": 4, "pass": 3}
})";

const std::string kProgram = std::string(EQUILUX_BIN_DIR) + "/equilux-session";

class PlantedAppTest : public testing::Test {
 protected:
  StudyFolder make_study(const char* name, const std::string& protocol, int width, int height) const {
    const StudyFolder folder = make_fake_study(folder_.path() / name, protocol, width, height);
    save_text(folder.session(), kProtocol);
    return folder;
  }
  ChildProcess show(const StudyFolder& folder) const {
    return ChildProcess(
        {kProgram, "run", folder.root.string(), "--experiment", "artifact", "--planted", "5", "--pace", "0"},
        {{"DISPLAY", display_.name()}, {"LIBGL_ALWAYS_SOFTWARE", "1"}});
  }

  TemporaryFolder folder_;
  XDisplay display_;
};

// What a subject saw and answered, without times.
Rows load_answers(const StudyFolder& folder) {
  return RawDatabase(folder.responses())
      .query(
          "SELECT code, session.id, kind, experiment, subject_index, seed, study_digest, manifest_digest,"
          " windows_digest, truth_digest, protocol_digest, complete, trial, phase, cell, test_key, pair_key,"
          " upper_key, test_side, answer FROM trial JOIN session ON session.id = session JOIN participant"
          " ON participant.id = participant ORDER BY session.id, trial");
}

Rows load_showings(const StudyFolder& folder) {
  return RawDatabase(folder.responses())
      .query(
          "SELECT session, trial, kind FROM event WHERE kind IN ('showing', 'answer', 'break', 'finish') "
          "ORDER BY id");
}

TEST_F(PlantedAppTest, LeavesTheLogOfTheHeadlessOneButForTimes) {
  const StudyFolder seen = make_study("seen", "pocket", 28, 21),
                    unseen = make_study("unseen", "pocket", 28, 21);
  for (int subject = 0; subject < 2; ++subject) {
    ChildProcess app = show(seen);
    ASSERT_EQ(app.wait(), 0) << app.read_output();
  }
  ChildProcess headless({kProgram, "simulate", unseen.root.string(), "--experiment", "artifact", "--subjects",
                         "2", "--seed", "5"});
  ASSERT_EQ(headless.wait(), 0) << headless.read_output();
  EXPECT_EQ(load_answers(seen).size(), 2u * (3 + 32 + 4));
  EXPECT_EQ(load_answers(seen), load_answers(unseen));
  EXPECT_EQ(load_showings(seen), load_showings(unseen));
}

int count_answered(const StudyFolder& folder) {
  if (!std::filesystem::exists(folder.responses())) return 0;
  try {
    return std::stoi(RawDatabase(folder.responses()).value("SELECT count(answer) FROM trial"));
  } catch (const std::runtime_error&) {  // not made yet
    return 0;
  }
}

// 480 trials of the paper's artifact experiment, with fake pictures of a quarter of its size: had each trial
// left its pictures in memory, 300 of them would have taken 300 x 3 x 280 x 210 x 4 = 212 MB.
TEST_F(PlantedAppTest, MemoryStaysFlatOverALongSession) {
  const StudyFolder folder = make_study("long", "paper", 280, 210);
  ChildProcess app = show(folder);
  const auto wait_for_answers = [&](int count) {
    return wait_until([&] { return count_answered(folder) >= count || !app.is_running(); });
  };
  ASSERT_TRUE(wait_for_answers(100)) << app.read_output();
  const std::size_t early = app.read_memory_bytes();
  ASSERT_TRUE(wait_for_answers(400)) << app.read_output();
  const std::size_t late = app.read_memory_bytes();
  ASSERT_TRUE(app.is_running()) << app.read_output();
  EXPECT_LT(late, early + (std::size_t{8} << 20));
  ASSERT_EQ(app.wait(), 0) << app.read_output();
  EXPECT_THAT(app.read_output(), HasSubstr("484 of 484 answers"));
}

}  // namespace
}  // namespace equilux
