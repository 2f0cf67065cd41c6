// What the way from logs to tables costs: time and memory against the number of answers.
#include <fmt/format.h>
#include <sys/resource.h>

#include "analysis/evidence.h"
#include "analysis/uncertainty.h"
#include "base/files.h"
#include "base/random.h"
#include "protocols/windows.h"
#include "tests/bench/bench.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

constexpr int kSubjectsPerLog = 21;  // of 480 trials: 10,080 answers a log

TrialRow make_trial(int number, const Cell& cell, RandomStream& random) {
  TrialRow trial;
  trial.number = number;
  trial.cell = cell;
  trial.test_key = format_key(Condition{cell, 0});
  trial.pair_key = trial.test_key;
  trial.test_side = random.next_below(2) == 0 ? Side::kLeft : Side::kRight;
  trial.answer = random.next_below(2) == 0 ? Side::kLeft : Side::kRight;
  trial.response_time_ns = 1'500'000'000;
  trial.answered_utc = "2026-01-31T12:00:00.000Z";
  return trial;
}

SessionRow make_session(const Study& study, int index) {
  SessionRow row;
  row.participant = fmt::format("P{}", index);
  row.subject_index = index;
  row.program_version = "bench";
  row.digests.study = study.digest;
  row.started_utc = "2026-01-31T12:00:00.000Z";
  return row;
}

void make_log(const StudyFolder& folder, const Study& study, const std::vector<Cell>& cells,
              std::uint64_t seed) {
  make_folder(folder.root);
  save_text(folder.study(), format_json(study.source));
  TrialLog log(folder.responses(), true);
  for (int subject = 0; subject < kSubjectsPerLog; ++subject) {
    RandomStream random(seed, "bench", static_cast<std::uint64_t>(subject));
    std::vector<TrialRow> trials;
    for (std::size_t i = 0; i < cells.size(); ++i)
      trials.push_back(make_trial(static_cast<int>(i), cells[i], random));
    log.finish_session(log.append_session(make_session(study, subject), trials), 1);
  }
}

double find_peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

void measure(const std::vector<StudyFolder>& folders, const Study& study) {
  std::vector<Evidence> parts;
  const double load = bench::time_s([&] {
    for (const StudyFolder& folder : folders) parts.push_back(load_evidence(folder, study, std::nullopt));
  });
  std::vector<AnswerRow> answers;
  std::int64_t session = 0;
  for (Evidence& part : parts) {
    for (AnswerRow& row : part.artifact.answers) {
      row.session += session;
      answers.push_back(std::move(row));
    }
    session += kSubjectsPerLog;
    part = {};
  }
  Tally tally;
  const double count = bench::time_s([&] { tally = tally_answers(answers, study); });
  ResponseMatrix matrix;
  const double arrange = bench::time_s([&] { matrix = make_response_matrix(answers); });
  const double disturb = bench::time_s(
      [&] { find_uncertainty(study, find_equivalence(study, tally, tally, nullptr), matrix, matrix, {}); });
  fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.0f} |\n", answers.size(), folders.size(),
             load, count, arrange, disturb, find_peak_mib());
}

void run() {
  const Study study = load_study(EQUILUX_SOURCE_DIR "/protocols/paper.json");
  const Windows windows = load_windows(study.windows_path, study);
  std::vector<Cell> cells;
  for (const Column& column : enumerate_columns(study)) {
    for (int i = 0; i < kWindowLevels; ++i)
      cells.push_back({column, windows.by_column.at(column).first_level + i, false});
  }
  const TempFolder temporary;
  std::vector<StudyFolder> folders;
  fmt::print(
      "| answers | logs | load, s | tally, s | matrix, s | uncertainty, s | peak, MiB "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const std::size_t logs : {1, 10, 100}) {
    while (folders.size() < logs) {
      folders.push_back({temporary / std::to_string(folders.size())});
      make_log(folders.back(), study, cells, folders.size());
    }
    measure(folders, study);
  }
}

}  // namespace
}  // namespace equilux

int main() { equilux::run(); }
