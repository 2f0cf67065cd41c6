// Every rule of responses.sql, broken by hand in a log: whoever reads it is told where, whichever check it
// asks for.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// What breaks a rule, and what the analysis says then.
struct Break {
  const char* change;
  const char* message;
};
void PrintTo(const Break& broken, std::ostream* stream) { *stream << broken.change; }

class BrokenRows : public ::testing::Test {
 protected:
  BrokenRows() {
    TrialLog log(path_, true);
    const auto session = log.append_session(make_fake_session(), make_fake_trials(6));
    log.append_field(session, "refresh_hz", "60");
    answer_all(log, session, 6);
    log.append_session(make_fake_session(1), make_fake_trials(4));
  }

  // As the analysis does.
  void read() const {
    const TrialLog log = TrialLog::load_snapshot(path_, LogCheck::kTables);
    log.load_sessions();
    log.load_brief_trials();
  }
  std::string refusal_by_tables() const {
    return message_of<InputError>([&] { read(); });
  }
  void expect_refused(const Break& broken) const {
    EXPECT_THAT(refusal_by_tables(), AllOf(StartsWith(path_.string()), HasSubstr(broken.message),
                                           HasSubstr("keep this file as it is")))
        << broken.change;
    EXPECT_THAT(message_of<InputError>([&] { TrialLog(path_).load_sessions(); }),
                HasSubstr("keep this file as it is"))
        << broken.change;
  }
  void change(const std::string& sql) const {
    RawDatabase(path_).query("PRAGMA ignore_check_constraints = ON; " + sql);
  }
  // Past types and NOT NULL, which a table without them would take.
  void change_freely(const std::string& table, const std::string& sql) const {
    const std::string where = " WHERE type = 'table' AND name = '" + table + "'";
    const std::string strict = RawDatabase(path_).value("SELECT sql FROM sqlite_schema" + where);
    const std::string writable = "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = ";
    RawDatabase(path_).query(writable + "replace(replace(sql, ') STRICT', ')'), 'NOT NULL', '')" + where);
    change(sql);
    std::string quoted;
    for (const char c : strict) quoted += c == '\'' ? std::string("''") : std::string(1, c);
    RawDatabase(path_).query(writable + "'" + quoted + "'" + where);
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "responses.sqlite";
};

TEST_F(BrokenRows, AreToldFromWholeOnes) {
  change("UPDATE trial SET answer = answer");
  change_freely("trial", "UPDATE trial SET answer = answer");
  EXPECT_NO_THROW(read());
  EXPECT_NO_THROW(TrialLog{path_});
}

constexpr Break kTrialBreaks[] = {
    {"trial = -1",
     "session 1, trial -1: trial: expected its place in the order of showing: 0, 1, ..., got -1"},
    {"trial = trial + 4294967296", "session 1, trial 4294967298: trial: expected its place"},
    {"phase = 'warm-up'", "session 1, trial 2: phase: expected practice, main or catch, got \"warm-up\""},
    {"phase = ''", "trial 2: phase: expected practice, main or catch, got \"\";"},
    {"phase = 'main' || char(0, 27) || hex(zeroblob(99))",
     "trial 2: phase: expected practice, main or catch, got \"main\\u0000\\u001b000"},
    {"cell = 'G1'", "session 1, trial 2: cell: expected"},
    {"test_side = 'up'", "session 1, trial 2: test_side: expected left or right, got \"up\""},
    {"answer = 'LEFT'", "session 1, trial 2: answer: expected left or right, got \"LEFT\""},
    {"response_time_ns = 0", "session 1, trial 2: response_time_ns: expected more than 0, got 0"},
    {"response_time_ns = -5", "session 1, trial 2: response_time_ns: expected more than 0, got -5"},
    {"response_time_ns = NULL", "trial 2: response_time_ns: expected one where there is an answer"},
    {"answered_utc = NULL", "trial 2: answered_utc: expected one where there is an answer"},
    {"answer = NULL",
     "trial 2: response_time_ns: expected one where there is an answer, and there alone, got"},
    {"answer = NULL, response_time_ns = NULL",
     "trial 2: answered_utc: expected one where there is an answer"},
    {"too_fast = 2", "session 1, trial 2: too_fast: expected 0 or 1, got 2"},
    {"too_fast = -1", "session 1, trial 2: too_fast: expected 0 or 1, got -1"},
};

class BrokenTrial : public BrokenRows, public ::testing::WithParamInterface<Break> {};
TEST_P(BrokenTrial, IsNamedWithItsPlace) {
  change(std::string("UPDATE trial SET ") + GetParam().change + " WHERE session = 1 AND trial = 2");
  if (std::string_view(GetParam().change) == "cell = 'G1'" ||
      std::string_view(GetParam().change).starts_with("trial = trial")) {
    EXPECT_THAT(refusal_by_tables(), HasSubstr(GetParam().message)) << "which no CHECK finds";
  } else {
    expect_refused(GetParam());
  }
}
INSTANTIATE_TEST_SUITE_P(Each, BrokenTrial, ::testing::ValuesIn(kTrialBreaks));

constexpr Break kOtherBreaks[] = {
    {"UPDATE log SET id = 2", "CHECK constraint failed in log"},
    {"UPDATE log SET station = ''", "CHECK constraint failed in log"},
    {"UPDATE participant SET code = '' WHERE id = 1", "CHECK constraint failed in participant"},
    {"UPDATE session SET uuid = '' WHERE id = 1", "CHECK constraint failed in session"},
    {"UPDATE session SET station = ''", "CHECK constraint failed in session"},
    {"UPDATE session SET kind = 'robot'", "CHECK constraint failed in session"},
    {"UPDATE session SET experiment = 'both'", "CHECK constraint failed in session"},
    {"UPDATE session SET subject_index = -1 WHERE id = 1", "CHECK constraint failed in session"},
    {"UPDATE session SET seed = -1", "CHECK constraint failed in session"},
    {"UPDATE session SET complete = 2", "CHECK constraint failed in session"},
    {"UPDATE session SET participant = 99", "a session whose participant is not there"},
    {"UPDATE session SET degrees_wide = 9e999 WHERE id = 1",
     "session 1: degrees_wide: expected a finite number, got inf"},
    {"UPDATE session SET degrees_high = -9e999 WHERE id = 2", "session 2: degrees_high: expected a finite"},
    {"UPDATE session SET viewing_distance_m = 9e999", "session 1: viewing_distance_m: expected a finite"},
    {"DELETE FROM field; DELETE FROM session WHERE id = 1",
     "session 1, trial 0: expected a row of a session that is there, got one of none"},
    {"UPDATE field SET session = 7",
     "session 7, field refresh_hz: expected a row of a session that is there"},
    {"DELETE FROM event; DELETE FROM trial WHERE session = 1",
     "session 1: complete: expected trials of a session that is finished, got none"},
    {"UPDATE field SET name = ''", "CHECK constraint failed in field"},
    {"UPDATE event SET kind = '' WHERE id = 3", "an event without a kind"},
};

class BrokenOther : public BrokenRows, public ::testing::WithParamInterface<Break> {};
TEST_P(BrokenOther, IsRefused) {
  change(GetParam().change);
  expect_refused(GetParam());
}
INSTANTIATE_TEST_SUITE_P(Each, BrokenOther, ::testing::ValuesIn(kOtherBreaks));

struct WrongType {
  const char* table;
  const char* change;
  const char* message;
};
void PrintTo(const WrongType& wrong, std::ostream* stream) { *stream << wrong.table << ": " << wrong.change; }

constexpr WrongType kWrongTypes[] = {
    {"trial", "trial = 'two'", "non-INTEGER value in trial.trial"},
    {"trial", "test_side = x'6c656674'", "non-TEXT value in trial.test_side"},
    {"trial", "response_time_ns = 'long'", "non-INTEGER value in trial.response_time_ns"},
    {"trial", "response_time_ns = 1.5", "non-INTEGER value in trial.response_time_ns"},
    {"trial", "pair_key = x'00'", "non-TEXT value in trial.pair_key"},
    {"trial", "upper_key = NULL", "NULL value in trial.upper_key"},
    {"trial", "cell = NULL", "NULL value in trial.cell"},
    {"trial", "answered_utc = x'00'", "non-TEXT value in trial.answered_utc"},
    {"session", "monitor = NULL", "NULL value in session.monitor"},
    {"session", "viewing_distance_m = 'far'", "non-REAL value in session.viewing_distance_m"},
    {"event", "detail = NULL", "NULL value in event.detail"},
    {"event", "time_ns = 'late'", "non-INTEGER value in event.time_ns"},
    {"field", "value = NULL", "NULL value in field.value"},
};

class WrongTypes : public BrokenRows, public ::testing::WithParamInterface<WrongType> {};
TEST_P(WrongTypes, AreRefusedInColumnsThatNobodyReadsToo) {
  const WrongType& wrong = GetParam();
  change_freely(wrong.table,
                std::string("UPDATE ") + wrong.table + " SET " + wrong.change + " WHERE rowid = 1");
  expect_refused({wrong.change, wrong.message});
}
INSTANTIATE_TEST_SUITE_P(Each, WrongTypes, ::testing::ValuesIn(kWrongTypes));

// As a program leaves it that writes a table anew without STRICT.
// The report reads no events of sessions that are not there.
TEST_F(BrokenRows, AnEventOfNoSessionIsRefusedByTheWholeCheck) {
  change("UPDATE event SET session = 9, trial = NULL WHERE id = 3");
  EXPECT_THAT(message_of<InputError>([&] { TrialLog log(path_); }),
              HasSubstr("session 9, event 3: expected a row of a session that is there"));
}

TEST_F(BrokenRows, OfATableThatTakesAnyTypeAreRefusedByItsChecks) {
  for (const char* change_one : {"too_fast = 0.5", "too_fast = 'x'", "phase = x'6d61696e'"}) {
    const std::filesystem::path copy = folder_.path() / "loose.sqlite";
    std::filesystem::copy_file(path_, copy, std::filesystem::copy_options::overwrite_existing);
    RawDatabase loose(copy);
    loose.query(
        "PRAGMA ignore_check_constraints = ON; PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql ="
        " replace(sql, ') STRICT', ')') WHERE type = 'table' AND name = 'trial'");
    RawDatabase(copy).query(std::string("PRAGMA ignore_check_constraints = ON; UPDATE trial SET ") +
                            change_one + " WHERE session = 1 AND trial = 2");
    EXPECT_THAT(message_of<InputError>([&] { TrialLog::load_snapshot(copy, LogCheck::kTables); }),
                HasSubstr("CHECK constraint failed in trial"))
        << change_one;
  }
}

// Of which the lower 32 bits are a number as it should be.
TEST_F(BrokenRows, ANumberOfATrialThatHasNoPlaceIsNamedAndNotCutToOneThatHas) {
  change("UPDATE trial SET trial = trial + 4294967296 WHERE session = 1");
  const auto expect_named = [&](const std::string& message) {
    EXPECT_THAT(message, AllOf(StartsWith(path_.string()), HasSubstr("keep this file as it is"),
                               HasSubstr("session 1, trial 4294967296: trial: expected its place in the "
                                         "order of showing: 0, 1, ..., got 4294967296;")));
  };
  expect_named(message_of<InputError>([&] { TrialLog(path_).load_trials(1); }));
  expect_named(refusal_by_tables());
  EXPECT_NO_THROW(TrialLog(path_).load_trials(2));
}

TEST_F(BrokenRows, AnEventOfATrialThatHasNoPlaceIsNamed) {
  change("UPDATE event SET trial = -4294967296 WHERE session = 1 AND trial = 0");
  EXPECT_THAT(
      message_of<InputError>([&] { TrialLog(path_).load_events(1); }),
      AllOf(StartsWith(path_.string()), HasSubstr("session 1, trial -4294967296: trial: expected its"),
            HasSubstr("got -4294967296; keep this file as it is")));
}

TEST_F(BrokenRows, ATrialThatIsNotThereIsNamed) {
  change("DELETE FROM trial WHERE session = 1 AND trial = 3");
  EXPECT_THAT(refusal_by_tables(), HasSubstr("session 1: expected its trial 3, got none: the next is 4"));
}

}  // namespace
}  // namespace equilux
