// All trials of a log in one go, each value held to what responses.sql allows.
#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <set>
#include <utility>

#include "base/error.h"
#include "base/json.h"
#include "experiment/log_rows.h"
#include "experiment/log_schema.h"

namespace equilux {
namespace {

constexpr std::size_t kUsualTrials = 512;  // of a session: so that most lists of them never grow

// The table itself, not its index, which may lack a row.
constexpr const char* kQuery =
    "SELECT session, trial, phase, cell, test_key, test_side, answer, response_time_ns, answered_utc, "
    "too_fast"
    " FROM trial NOT INDEXED";
enum Column {
  kSession,
  kTrial,
  kPhase,
  kCell,
  kTestKey,
  kTestSide,
  kAnswer,
  kResponseTime,
  kAnsweredUtc,
  kTooFast
};

std::optional<Phase> find_phase(std::string_view text) {
  if (text == "main") return Phase::kMain;
  if (text == "catch") return Phase::kCatch;
  if (text == "practice") return Phase::kPractice;
  return std::nullopt;
}

std::optional<Side> find_side(std::string_view text) {
  if (text == "left") return Side::kLeft;
  if (text == "right") return Side::kRight;
  return std::nullopt;
}

// A picture's key ends in its view.
std::optional<int> find_view(std::string_view key) {
  if (key.ends_with("v0")) return 0;
  if (key.ends_with("v1")) return 1;
  return std::nullopt;
}

// Numbers of short keys by their bytes, asked before a CellReader: of a log's cells each has a thousand
// trials. Where two keys have one place, the later one takes it.
class KeyMemo {
 public:
  std::optional<std::uint32_t> find(std::string_view key) const {
    if (key.empty() || key.size() > kLongest) return std::nullopt;
    const Bytes bytes = pack(key);
    const Entry& entry = entries_[place_of(bytes)];
    return entry.bytes == bytes ? std::optional(entry.number) : std::nullopt;
  }
  void note(std::string_view key, std::uint32_t number) {
    if (key.empty() || key.size() > kLongest) return;
    const Bytes bytes = pack(key);
    entries_[place_of(bytes)] = {bytes, number};
  }

 private:
  static constexpr std::size_t kLongest = 23, kPlaces = 4096;
  using Bytes = std::array<std::uint64_t, 3>;  // the key, zeros, and its length in the last byte
  struct Entry {
    Bytes bytes{};
    std::uint32_t number = 0;
  };

  static Bytes pack(std::string_view key) {
    Bytes bytes{};
    std::memcpy(bytes.data(), key.data(), key.size());
    bytes[2] |= static_cast<std::uint64_t>(key.size()) << 56;
    return bytes;
  }
  static std::size_t place_of(const Bytes& bytes) {
    const std::uint64_t mixed =
        (bytes[0] * 0x9E3779B97F4A7C15U ^ bytes[1] * 0xC2B2AE3D27D4EB4FU ^ bytes[2]) * 0x9E3779B97F4A7C15U;
    return mixed >> 52;
  }

  std::vector<Entry> entries_ = std::vector<Entry>(kPlaces);
};

class Reader {
 public:
  Reader(const Database& database, CellReader& cells)
      : source_(database.name()), row_(database, kQuery), cells_(cells) {}

  bool step() { return row_.step(); }
  std::int64_t session() const { return row_.integer(kSession); }

  BriefTrial read() {
    BriefTrial trial;
    trial.number = read_number();
    trial.phase = take(find_phase(row_.view(kPhase)), kPhase, "phase", "practice, main or catch");
    trial.cell = read_cell();
    trial.view = find_view(row_.view(kTestKey));
    trial.test_side = take(find_side(row_.view(kTestSide)), kTestSide, "test_side", "left or right");
    trial.too_fast = read_flag();
    const bool is_open = row_.is_null(kAnswer);
    if (row_.is_null(kResponseTime) != is_open) refuse(kResponseTime, "response_time_ns", kWithAnswer);
    if (row_.is_null(kAnsweredUtc) != is_open) refuse(kAnsweredUtc, "answered_utc", kWithAnswer);
    if (is_open) return trial;
    trial.answer = take(find_side(row_.view(kAnswer)), kAnswer, "answer", "left or right");
    trial.response_time_ns = row_.integer(kResponseTime);
    if (trial.response_time_ns <= 0) refuse(kResponseTime, "response_time_ns", "more than 0");
    return trial;
  }

 private:
  static constexpr const char* kWithAnswer = "one where there is an answer, and there alone";

  int read_number() const {
    const std::int64_t number = row_.integer(kTrial);
    if (number < 0 || number > std::numeric_limits<int>::max()) refuse(kTrial, "trial", kTrialNumber);
    return static_cast<int>(number);
  }
  // Without a place in words until there is a new key.
  std::uint32_t read_cell() {
    const std::string_view key = row_.view(kCell);
    if (const auto noted = memo_.find(key)) return *noted;
    const auto known = cells_.find(key);
    const std::uint32_t number = known ? *known : cells_.number_of(key, source_, place("cell"));
    memo_.note(key, number);
    return number;
  }
  bool read_flag() const {
    const std::int64_t flag = row_.integer(kTooFast);
    if (flag != 0 && flag != 1) refuse(kTooFast, "too_fast", "0 or 1");
    return flag != 0;
  }
  template <typename T>
  T take(const std::optional<T>& value, Column column, std::string_view name,
         std::string_view expected) const {
    if (!value) refuse(column, name, expected);
    return *value;
  }

  std::string place(std::string_view name) const {
    return fmt::format("session {}, trial {}: {}", session(), row_.integer(kTrial), name);
  }
  [[noreturn]] void refuse(Column column, std::string_view name, std::string_view expected) const {
    throw InputError(source_, place(name), expected, fmt::format("{}; {}", show(column), kDamageAdvice));
  }
  // Texts escaped and cut short: they may hold anything.
  std::string show(Column column) const {
    if (row_.is_null(column)) return "none";
    if (column == kTrial || column == kResponseTime || column == kTooFast) return row_.text(column);
    return describe_json(Json(row_.text(column)));
  }

  std::string source_;
  Statement row_;
  CellReader& cells_;
  KeyMemo memo_;
};

// Trials and sessions by each other, which LogCheck::kTables leaves to this.
void check_belonging(const Database& database, const BriefTrials& brief) {
  Statement row(database, "SELECT id, complete FROM session NOT INDEXED");
  std::set<std::int64_t> sessions;
  while (row.step()) {
    sessions.insert(row.integer(0));
    if (row.integer(1) != 0 && !brief.by_session.contains(row.integer(0)))
      refuse_without_trials(database.name(), row.integer(0));
  }
  for (const auto& [session, trials] : brief.by_session) {
    if (!sessions.contains(session))
      refuse_orphan(database.name(), session, fmt::format("trial {}", trials.front().number));
  }
}

}  // namespace

BriefTrials load_brief_trials(const Database& database, CellReader& cells) {
  Reader reader(database, cells);
  BriefTrials brief;
  std::vector<BriefTrial>* trials = nullptr;
  std::int64_t session = 0;
  while (reader.step()) {
    if (const std::int64_t next = reader.session(); !trials || next != session) {
      session = next;
      trials = &brief.by_session[session];
      trials->reserve(kUsualTrials);
    }
    trials->push_back(reader.read());
  }
  const auto by_number = [](const BriefTrial& a, const BriefTrial& b) { return a.number < b.number; };
  for (auto& [id, of_session] : brief.by_session) {
    if (!std::is_sorted(of_session.begin(), of_session.end(), by_number))
      std::sort(of_session.begin(), of_session.end(), by_number);
    check_numbers(database.name(), id, of_session);
  }
  check_belonging(database, brief);
  brief.cells = cells.cells();
  return brief;
}

}  // namespace equilux
