// The door to a session: what it lets in, what it lets go on, and whom it refuses.
#include "experiment/open_session.h"

#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "experiment/schedule.h"
#include "tests/experiment/open_session_fixture.h"
#include "tests/experiment/raw_database.h"
#include "tests/experiment/schedule_checks.h"
#include "tests/experiment/unprivileged.h"

namespace equilux {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

TEST_F(OpenSessionTest, BeginsWithAWrittenSchedule) {
  const OpenSession session = open("P1");
  EXPECT_FALSE(session.resumed);
  EXPECT_EQ(session.row.subject_index, 0);
  EXPECT_EQ(session.row.seed, 77u);
  EXPECT_EQ(session.session.trials.size(), 32u);
  EXPECT_EQ(session.session.screen, Screen::kInstructions);
  EXPECT_EQ(log_.load_trials(session.row.id).size(), 32u);
  const SessionRow row = log_.load_sessions().at(0);
  EXPECT_EQ(row.participant, "P1");
  EXPECT_EQ(row.screen.monitor, "DP-1");
  EXPECT_EQ(row.screen.degrees_wide, std::optional(16.0));
  EXPECT_EQ(row.digests, session.row.digests);
}

TEST_F(OpenSessionTest, RecordsWhatASessionWasMadeFrom) {
  const Study study = load_folder_study(folder_);
  const SessionDigests artifact = open("P1").row.digests;
  EXPECT_EQ(artifact.study, study.digest);
  EXPECT_EQ(artifact.windows, load_windows(folder_.windows(), study).digest);
  EXPECT_EQ(artifact.manifest.size(), 64u);
  EXPECT_EQ(artifact.selection, "");
  EXPECT_EQ(artifact.truth, "");
  const Selection selection = save_fake_selection(folder_, SubjectKind::kPerson, {4, 6, 10});
  const SessionDigests material = open("P1", Experiment::kMaterial).row.digests;
  EXPECT_EQ(material.windows, "");
  EXPECT_EQ(material.selection, digest_selection(selection));
  EXPECT_NE(material.manifest, artifact.manifest);
}

TEST_F(OpenSessionTest, GivesTheLowestFreeIndexOfTheKind) {
  EXPECT_EQ(open("P1").row.subject_index, 0);
  EXPECT_EQ(open("P2").row.subject_index, 1);
  SessionRequest planted = request_of("planted-77-0");
  planted.kind = SubjectKind::kPlanted;
  EXPECT_EQ(open_session(folder_, log_, planted).row.subject_index, 0);
}

TEST_F(OpenSessionTest, KeepsTheStationThatItWasToldLast) {
  SessionRequest second = request_of("P1");
  second.lane = Lane{1, 3};
  EXPECT_EQ(open_session(folder_, log_, second).row.subject_index, 1);
  const OpenSession later = open("P2");
  EXPECT_EQ(later.row.subject_index, 4) << "though nobody said it again";
  EXPECT_EQ(log_.load_sessions().at(1).fields.at("lane"), "2/3");
  EXPECT_EQ(find_lane(&log_, {}), (Lane{1, 3}));
  EXPECT_EQ(find_lane(nullptr, {}), Lane());
  second.participant = "P3";
  second.lane = Lane{};
  EXPECT_EQ(open_session(folder_, log_, second).row.subject_index, 0);
  EXPECT_EQ(open("P4").row.subject_index, 2) << "the lowest that is free";
}

TEST_F(OpenSessionTest, RefusesANameForACodeAndOneThatDiffersFromAnotherInCase) {
  for (const char* code : {"", " ", "Anna M", "Anna\nM", "M\u00fcller", "a/b", "=1", "Anna", "anna.m"})
    expect_refused(HasSubstr("expected a code and no name: a digit or more beside letters"), code);
  expect_refused(HasSubstr("at most 64"), std::string(65, '1'));
  open("P1");
  expect_refused(
      AllOf(HasSubstr("in more than the case of letters"), HasSubstr("p1, where session 1 is of P1")), "p1");
  EXPECT_EQ(open("p-1_b.c").row.participant, "p-1_b.c");
}

// Before anybody is asked to agree: the window looks for an unfinished session first.
TEST_F(OpenSessionTest, RefusesAWithdrawnCodeAtTheDoor) {
  open("P2");
  RawDatabase(folder_.responses())
      .query(fmt::format("INSERT INTO tombstone VALUES ('salt', '{}', '2026-01-31T12:00:00.000Z')",
                         digest_text("saltP1")));
  const SessionRequest request = request_of("P1");
  const SessionInputs inputs = load_session_inputs(folder_, &log_, request);
  EXPECT_THAT([&] { find_unfinished_session(inputs, log_, request); },
              ThrowsMessage<InputError>(HasSubstr("P1, withdrawn on ")));
}

// A study that names a protocol has consent and practice in it.
TEST_F(OpenSessionTest, RefusesAStudyWithoutTheSessionProtocolThatItNames) {
  Json study = load_study(protocol_path("pocket")).source;
  study.set("image", Json().set("width", 4).set("height", 3));
  save_text(folder_.study(), format_json(study));
  Manifest manifest = load_manifest(folder_.manifest());
  manifest.study_digest = load_folder_study(folder_).digest;
  save_manifest(manifest, folder_.manifest());
  expect_refused(AllOf(HasSubstr("session.json: expected the session protocol that the study names"),
                       HasSubstr("nothing of that name")));
  save_text(folder_.session(), R"({"schema": "equilux-session", "schema_version": 1})");
  EXPECT_EQ(open("P1").session.trials.size(), 32u);
}

TEST_F(OpenSessionTest, SaysWhichTrialALogLacks) {
  open("P1");
  RawDatabase(folder_.responses()).query("DELETE FROM trial WHERE trial = 7");
  expect_refused(HasSubstr("session 1: expected its trial 7, got none: the next is 8"));
}

TEST_F(OpenSessionTest, GoesOnWithTheParticipantsUnfinishedSession) {
  const SessionRow begun = open("P1").row;
  open("P2");
  log_.append_answer(begun.id, {0, Side::kLeft, 5}, 1, 9);
  SessionRequest request = request_of("P1");
  request.seed = 99;
  request.screen.monitor = "DP-2";
  const OpenSession resumed = open_session(folder_, log_, request);
  EXPECT_TRUE(resumed.resumed);
  EXPECT_EQ(resumed.row.id, begun.id);
  EXPECT_EQ(resumed.row.seed, 77u);
  EXPECT_EQ(resumed.session.current, 1);
  EXPECT_EQ(resumed.session.trials[0].answer, std::optional(Side::kLeft));
  EXPECT_EQ(log_.load_sessions().size(), 2u);
  const auto events = load_events(folder_.responses());
  EXPECT_EQ(events.back().at(2), "resume");
  EXPECT_THAT(events.back().at(4), HasSubstr("DP-2"));
}

// Two windows would answer the same trials by turns.
TEST_F(OpenSessionTest, RefusesASessionThatAnotherWindowRuns) {
  const SessionRequest request = request_of("P1");
  {
    const OpenSession running = open("P1");
    const auto names_it =
        AllOf(HasSubstr(folder_.responses().string()),
              HasSubstr("session 1 of P1, artifact experiment, which runs in another window"));
    expect_refused(names_it);
    EXPECT_EQ(load_events(folder_.responses()).size(), 0u) << "not even a resume";
    const SessionInputs inputs = load_session_inputs(folder_, &log_, request);
    EXPECT_THAT([&] { check_not_running(inputs, log_, request); }, ThrowsMessage<InputError>(names_it));
    EXPECT_NO_THROW(check_not_running(inputs, log_, request_of("P2")));
    EXPECT_EQ(open("P2").row.subject_index, 1) << "others may sit in other windows";
    EXPECT_EQ(TrialLog::load_snapshot(folder_.responses()).load_sessions().size(), 2u);
  }
  EXPECT_TRUE(open("P1").resumed);
}

TEST_F(OpenSessionTest, RecordsWhatIsMeasuredAnewWhereItGoesOn) {
  open("P1");
  SessionRequest request = request_of("P1");
  request.fields = {{"refresh_hz", "59.95"}, {"gl_renderer", "another"}};
  open_session(folder_, log_, request);
  EXPECT_THAT(load_events(folder_.responses()).back().at(4),
              AllOf(HasSubstr("\"refresh_hz\":\"59.95\""), HasSubstr("another")));
}

TEST_F(OpenSessionTest, FinishesASessionThatWasKilledAfterItsLastAnswer) {
  const std::int64_t begun = open("P1").row.id;
  for (const TrialRow& trial : log_.load_trials(begun)) {
    log_.append_answer(begun, {trial.number, Side::kLeft, 5}, std::nullopt, 9);
  }
  OpenSession resumed = open("P1");
  for (const SessionEffect& effect : advance(resumed.session, ContinueEvent{3})) {
    record_effect(log_, resumed.row.id, effect);
  }
  EXPECT_EQ(resumed.session.screen, Screen::kThanks);
  EXPECT_TRUE(log_.load_sessions().at(0).complete);
}

TEST_F(OpenSessionTest, RefusesAParticipantWhoHasFinished) {
  finish(open("P1"));
  expect_refused(
      AllOf(HasSubstr("has not finished the artifact experiment"), HasSubstr("P1, of finished session 1")));
  EXPECT_NO_THROW(open("P2"));
}

TEST_F(OpenSessionTest, TheInterruptedOneIsTheLastThatRunsInNoWindow) {
  EXPECT_EQ(find_interrupted(folder_), std::nullopt);
  finish(open("P1"));
  log_.append_event(open("P2").row.id, "abort", 1, "tired");
  EXPECT_EQ(find_interrupted(folder_), std::nullopt) << "all of them ended";
  open("P3");
  open("P4");
  EXPECT_EQ(find_interrupted(folder_)->participant, "P4");
  const OpenSession running = open("P5");
  EXPECT_EQ(find_interrupted(folder_)->participant, "P4");
  const OpenSession resumed = open("P4");
  EXPECT_EQ(find_interrupted(folder_)->participant, "P3");
}

// Else somebody reads, agrees and answers questions for a session that cannot begin.
TEST_F(OpenSessionTest, IsKnownBeforehandToHaveNowhereToRecord) {
  EXPECT_NO_THROW(check_can_record(folder_));
  EXPECT_THAT([&] { check_can_record(folder_, std::uintmax_t{1} << 62); },
              ThrowsMessage<StoreError>(AllOf(HasSubstr(folder_.root.string()), HasSubstr("MiB are free"))));
  const ReadOnlyFolder read_only(folder_.root);
  EXPECT_THAT(
      [&] { check_can_record(folder_); },
      ThrowsMessage<StoreError>(HasSubstr(folder_.root.string() + ": cannot be written: Permission")));
}

TEST_F(OpenSessionTest, RecordsEachEffectOfASession) {
  OpenSession open_one = open("P1");
  const auto record_all = [&](const SessionEvent& event) {
    for (const SessionEffect& effect : advance(open_one.session, event)) {
      record_effect(log_, open_one.row.id, effect);
    }
  };
  record_all(ContinueEvent{1});
  record_all(ShownEvent{0, 2});
  record_all(AnswerEvent{Side::kRight, 5});
  record_all(AbortEvent{"escape", 6});
  EXPECT_EQ(log_.load_trials(1).at(0).response_time_ns, std::optional<std::int64_t>(3));
  std::vector<std::string> kinds;
  for (const auto& event : load_events(folder_.responses())) kinds.push_back(event.at(2));
  EXPECT_EQ(kinds, (std::vector<std::string>{"showing", "answer", "showing", "abort"}));
}

TEST_F(OpenSessionTest, DrawsSeedsThatTheLogCanKeep) {
  std::set<std::uint64_t> seeds;
  for (int i = 0; i < 100; ++i) {
    seeds.insert(draw_seed());
    EXPECT_LT(*seeds.rbegin(), std::uint64_t{1} << 63);
  }
  EXPECT_EQ(seeds.size(), 100u);
}

// Through the door, not only through make_schedule: 12 persons of the pocket study, session seed 77; exact.
TEST_F(OpenSessionTest, BalancesTheSessionsItOpens) {
  const Study study = load_folder_study(folder_);
  BalanceOverSubjects balance(study, Experiment::kArtifact);
  for (int i = 0; i < 12; ++i) {
    const auto session = open(fmt::format("P{}", i));
    EXPECT_THAT(check_session_balance(session.session.trials), IsEmpty());
    EXPECT_THAT(balance.add(log_.load_trials(session.row.id)), IsEmpty());
  }
}

// A protocol with practice and catch trials, which may go on for a day after an interruption.
class OpenSessionByProtocol : public OpenSessionTest {
 protected:
  void save_protocol(const std::string& members) const {
    save_text(folder_.session(), R"({"schema": "equilux-session", "schema_version": 1, )" + members + "}");
  }
};

TEST_F(OpenSessionByProtocol, WritesPracticeAndCatchTrialsIntoTheSchedule) {
  save_protocol(R"("familiarisation": {"objects": true, "examples": 2, "practice_trials": 3},
                   "catch_trials": {"count": 2, "pass": 2}, "least_response_ms": 150, "breaks": {"every_trials": 9})");
  const OpenSession session = open("P1");
  EXPECT_EQ(session.session.trials.size(), 32u + 5);
  EXPECT_EQ(session.session.rules.familiar_pages, 4 + 2);
  EXPECT_EQ(session.session.rules.least_response_ns, 150'000'000);
  EXPECT_EQ(session.session.rules.break_every_trials, std::optional(9));
  EXPECT_EQ(log_.load_sessions().at(0).digests.protocol, load_session_protocol(folder_.session()).digest);
  const auto trials = log_.load_trials(session.row.id);
  EXPECT_EQ(std::count_if(trials.begin(), trials.end(),
                          [](const auto& trial) { return trial.phase == Phase::kMain; }),
            32);
}

TEST_F(OpenSessionByProtocol, KeepsTheFieldsOfANewSession) {
  SessionRequest request = request_of("P1");
  request.fields = {{"age_band", "30-39"}};
  open_session(folder_, log_, request);
  EXPECT_EQ(log_.load_sessions().at(0).fields, request.fields);
}

TEST_F(OpenSessionByProtocol, RefusesAnotherProtocolOnceASessionHasBegun) {
  save_protocol(R"("least_response_ms": 150)");
  open("P1");
  save_protocol(R"("least_response_ms": 151)");
  expect_refused(HasSubstr("session protocol"), "P2");
  save_protocol(R"("least_response_ms": 150, "consent": {"version": "2", "text": ["new"]})");
  EXPECT_NO_THROW(open("P2"));
}

TEST_F(OpenSessionByProtocol, LetsNobodyGoOnWhereItSaysSo) {
  save_protocol(R"("resume": {"allowed": false})");
  open("P1");
  expect_refused(AllOf(HasSubstr("/resume"), HasSubstr("in one go")));
}

TEST_F(OpenSessionByProtocol, LetsASessionGoOnForSoLong) {
  save_protocol(R"("resume": {"within_hours": 24})");
  SessionRequest request = request_of("P1");
  const std::string started = open_session(folder_, log_, request).row.started_utc;
  const auto in_days = [&](int days) {
    using namespace std::chrono;
    const auto number = [&](std::size_t at, std::size_t digits) {
      return std::stoi(started.substr(at, digits));
    };
    const year_month_day date{sys_days{year{number(0, 4)} / number(5, 2) / number(8, 2)} +
                              std::chrono::days{days}};
    return fmt::format("{}-{:02}-{:02}{}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                       static_cast<unsigned>(date.day()), started.substr(10));
  };
  request.now_utc = in_days(1);
  EXPECT_TRUE(open_session(folder_, log_, request).resumed);
  request.now_utc = in_days(2);
  EXPECT_THAT([&] { open_session(folder_, log_, request); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("at most 24 hours"), HasSubstr("48.0 hours ago"))));
}

// A clock that is behind would call every session fresh.
TEST_F(OpenSessionByProtocol, DoubtsTheAgeOfASessionWhereTheClockIsBehindTheLog) {
  save_protocol(R"("resume": {"within_hours": 24})");
  open("P1");
  open("P2");
  RawDatabase(folder_.responses()).query("UPDATE session SET started_utc = '2026-06-01T12:00:00.000Z'");
  RawDatabase(folder_.responses())
      .query("UPDATE session SET started_utc = '2026-06-02T00:00:00.000Z' WHERE id = 2");
  SessionRequest request = request_of("P1");
  const auto expect_doubt = [&](const std::string& now, const char* later) {
    request.now_utc = now;
    EXPECT_THAT(
        [&] { open_session(folder_, log_, request); },
        ThrowsMessage<InputError>(AllOf(HasSubstr("at most 24 hours ago"), HasSubstr("of unknown age"),
                                        HasSubstr("clock says " + now), HasSubstr(later))));
  };
  expect_doubt("2026-06-01T11:00:00.000Z", "13.0 hours later");
  expect_doubt("2026-06-01T13:00:00.000Z", "11.0 hours later");  // after it, but before the other's
  request.accepts_clock = true;
  EXPECT_TRUE(open_session(folder_, log_, request).resumed);
  EXPECT_THAT(load_events(folder_.responses()).back().at(4), HasSubstr("\"clock_behind_hours\":\"11.00\""));
  request.now_utc = "2026-06-02T13:00:00.000Z";
  EXPECT_THAT([&] { open_session(folder_, log_, request); },
              ThrowsMessage<InputError>(HasSubstr("25.0 hours ago")))
      << "too old by any clock";
}

TEST_F(OpenSessionByProtocol, KeepsThatTheClockWasBehindWhenASessionBegan) {
  open("P1");
  EXPECT_EQ(log_.load_sessions().at(0).fields.count("clock_behind_hours"), 0u);
  RawDatabase(folder_.responses()).query("UPDATE session SET started_utc = '9999-06-01T12:00:00.000Z'");
  open("P2");
  EXPECT_EQ(log_.load_sessions().at(1).fields.count("clock_behind_hours"), 1u);
}

// Nobody waits for a planted subject: its sessions go on whenever the program runs again.
TEST_F(OpenSessionByProtocol, LimitsTheResumingOfPersonsAlone) {
  save_protocol(R"("resume": {"allowed": false})");
  SessionRequest request = request_of("planted-1-0");
  request.kind = SubjectKind::kPlanted;
  open_session(folder_, log_, request);
  EXPECT_TRUE(open_session(folder_, log_, request).resumed);
}

TEST(LaneText, IsTheNumberOfAStationOfSoMany) {
  EXPECT_EQ(parse_lane("2/3", "--station").first, 1);
  EXPECT_EQ(parse_lane("2/3", "--station").step, 3);
  for (const char* text : {"", "2", "0/3", "4/3", "2/3x", "a/b", "-1/3", "1/0", "1/9999"}) {
    EXPECT_THAT([&] { parse_lane(text, "--station"); }, ThrowsMessage<InputError>(HasSubstr("--station")))
        << text;
  }
}

}  // namespace
}  // namespace equilux
