// A planted subject in front of the real window: the log of the headless one, and a session as long as the
// paper's.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <thread>

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
  ChildProcess show(const StudyFolder& folder, const std::string& pace = "0") const {
    return ChildProcess(
        {kProgram, "run", folder.root.string(), "--experiment", "artifact", "--planted", "5", "--pace", pace},
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

// The first pair was shown.
bool has_begun(const StudyFolder& folder) {
  if (!std::filesystem::exists(folder.responses())) return false;
  try {
    return !load_showings(folder).empty();
  } catch (const std::runtime_error&) {  // not made yet
    return false;
  }
}

// Nobody is there who could give it its size again: it says so, and does not wait for ever.
TEST_F(PlantedAppTest, BeforeAWindowThatBecomesAnotherSizeEndsWithAnError) {
  const StudyFolder folder = make_study("resized", "pocket", 28, 21);
  ChildProcess app = show(folder, "10");
  ASSERT_TRUE(wait_until([&] { return has_begun(folder); })) << app.read_output();
  display_.resize_windows(900, 700);
  EXPECT_NE(app.wait(), 0);
  EXPECT_THAT(app.read_output(), HasSubstr("expected the framebuffer with which the session began"));
}

TEST_F(PlantedAppTest, BeforeAMonitorThatIsUnpluggedEndsWithAnError) {
  const StudyFolder folder = make_study("unplugged", "pocket", 28, 21);
  ChildProcess app = show(folder, "10");
  ASSERT_TRUE(wait_until([&] { return has_begun(folder); })) << app.read_output();
  display_.unplug_monitor();
  EXPECT_EQ(app.wait(), 1);
  EXPECT_THAT(app.read_output(),
              HasSubstr("expected the monitor on which the session began, screen, got none"));
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

TEST_F(PlantedAppTest, TakesAnotherCodeWhereTheSubjectWithdrew) {
  const StudyFolder folder = make_study("again", "pocket", 28, 21);
  for (const char* code : {"planted-5-0", "planted-5-0-2"}) {
    ChildProcess app = show(folder);
    ASSERT_EQ(app.wait(), 0) << app.read_output();
    EXPECT_THAT(app.read_output(), HasSubstr(fmt::format("session of {} is complete", code)));
    ChildProcess withdrawal({kProgram, "withdraw", folder.root.string(), code, "--yes"});
    ASSERT_EQ(withdrawal.wait(), 0) << withdrawal.read_output();
  }
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

// As make_study, but all references are one small file, and all VPL pictures the same with so many bytes
// more, which are slow to read: what is behind the end of a PNG belongs to its digest.
StudyFolder make_uneven_study(const std::filesystem::path& root, std::size_t bytes) {
  constexpr int kWidth = 560, kHeight = 420;
  const StudyFolder folder = make_fake_study(root, "pocket", 4, 3);
  save_text(folder.session(), kProtocol);
  Json json = load_folder_study(folder).source;
  json.set("image", Json().set("width", kWidth).set("height", kHeight));
  save_text(folder.study(), format_json(json));
  Manifest manifest = load_manifest(folder.manifest());
  manifest.study_digest = load_folder_study(folder).digest;
  manifest.width = kWidth;
  manifest.height = kHeight;
  save_png(make_fake_picture("small", kWidth, kHeight), root / "small.png");
  save_text(root / "large.png", load_text(root / "small.png") + std::string(bytes, ' '));
  for (auto& [key, record] : manifest.pictures) {
    const bool is_reference = key.find("-ref-") != std::string::npos;
    const auto source = root / (is_reference ? "small.png" : "large.png");
    std::filesystem::remove(folder.root / record.file);
    std::filesystem::create_hard_link(source, folder.root / record.file);
    record.digest = digest_file(source);
  }
  save_manifest(manifest, folder.manifest());
  return folder;
}

// From one pair's onset to the next, where one answer alone came between: the next pair is read in this time.
// By the side of the next pair's test picture.
std::map<std::string, std::vector<double>> load_intervals_ms(const StudyFolder& folder) {
  std::map<std::string, std::vector<double>> intervals;
  std::optional<double> shown;
  std::string before;
  const auto events =
      RawDatabase(folder.responses())
          .query(
              "SELECT kind, time_ns, test_side FROM event LEFT JOIN trial USING (session, trial)"
              " ORDER BY event.id");
  for (const auto& row : events) {
    const double time = std::stod(row[1]) * 1e-6;
    if (row[0] == "showing") {
      if (shown && before == "answer") intervals[row[2]].push_back(time - *shown);
      shown = time;
    } else if (row[0] != "answer") {
      shown.reset();
    }
    before = row[0];
  }
  return intervals;
}

// Of the rank sum of the first, about normal for many values. source: Mann and Whitney (1947)
double find_rank_z(const std::vector<double>& first, const std::vector<double>& second) {
  double wins = 0;
  for (const double a : first) {
    for (const double b : second) wins += a > b ? 1 : a == b ? 0.5 : 0;
  }
  const auto m = static_cast<double>(first.size()), n = static_cast<double>(second.size());
  return (wins - m * n / 2) / std::sqrt(m * n * (m + n + 1) / 12);
}

double find_median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// A subject who answers at once, so that the next pair is not there before it has been read. Were it shown
// with its left picture alone there, or its test picture read behind everything, the onset would tell the
// side by the time that this picture takes more than its reference.
// How much that is, is seen beside a study whose pictures are all small.
TEST_F(PlantedAppTest, WhenAPairComesTellsNothingOfTheTestPicturesSide) {
  constexpr double kMostZ = 3.9;  // p of 1e-4
  const auto run_sessions = [&](const char* name, std::size_t bytes) {
    const StudyFolder folder = make_uneven_study(folder_.path() / name, bytes);
    for (int subject = 0; subject < 6; ++subject) {
      ChildProcess app = show(folder);
      EXPECT_EQ(app.wait(), 0) << app.read_output();
    }
    return load_intervals_ms(folder);
  };
  auto even = run_sessions("even", 0), uneven = run_sessions("uneven", std::size_t{12} << 20);
  std::vector<double>&left = uneven["left"], &right = uneven["right"];
  ASSERT_GT(left.size(), 80u);
  ASSERT_GT(right.size(), 80u);
  EXPECT_LT(std::abs(find_rank_z(left, right)), kMostZ);
  const double slower_ms = find_median(right) - find_median(even["right"]);
  EXPECT_GT(find_rank_z(right, even["right"]), kMostZ) << "the next pair is read in this time";
  for (double& interval : left) interval += slower_ms;
  EXPECT_GT(find_rank_z(left, right), kMostZ) << "a tell would be found";
}

}  // namespace
}  // namespace equilux
