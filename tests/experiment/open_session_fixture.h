// A folder of a study and its log, at whose door sessions are asked for.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "experiment/open_session.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"

namespace equilux {

class OpenSessionTest : public ::testing::Test {
 protected:
  SessionRequest request_of(const std::string& participant,
                            Experiment experiment = Experiment::kArtifact) const {
    return {experiment, SubjectKind::kPerson, participant,
            77,         std::nullopt,         {"DP-1", 1200, 1000, 0.4572, 16, 12}};
  }
  OpenSession open(const std::string& participant, Experiment experiment = Experiment::kArtifact) {
    return open_session(folder_, log_, request_of(participant, experiment));
  }
  void finish(const OpenSession& session) {
    answer_all(log_, session.row.id, static_cast<int>(session.session.trials.size()));
  }
  template <typename Matcher>
  void expect_refused(const Matcher& message, const std::string& participant = "P1",
                      Experiment experiment = Experiment::kArtifact) {
    const auto before = log_.load_sessions().size();
    EXPECT_THAT([&] { open(participant, experiment); }, ::testing::ThrowsMessage<InputError>(message));
    EXPECT_EQ(log_.load_sessions().size(), before);
  }
  void replace_in_file(const std::filesystem::path& path, const std::string& what, const std::string& by) {
    std::string text = load_text(path);
    const std::size_t place = text.find(what);
    ASSERT_NE(place, std::string::npos) << what;
    save_text(path, text.replace(place, what.size(), by));
  }

  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path());
  TrialLog log_{folder_.responses(), true};
};

}  // namespace equilux
