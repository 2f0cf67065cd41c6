// What the way from logs to tables costs: time and memory against the number of answers.
#include <fmt/format.h>
#include <sys/resource.h>

#include "analysis/program.h"
#include "base/files.h"
#include "base/random.h"
#include "protocols/windows.h"
#include "tests/bench/bench.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

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

SessionRow make_session(const Study& study, std::uint64_t seed, int index) {
  SessionRow row;
  row.participant = fmt::format("P{}-{}", seed, index);
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
    log.finish_session(log.append_session(make_session(study, seed, subject), trials), 1);
  }
}

double find_peak_mib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

// Processor seconds of all threads: what a shared machine does not blur.
double find_processor_s() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Cost {
  double wall_s = 0, processor_s = 0;
};

Cost time_both(const auto& body) {
  const double before = find_processor_s();
  Cost cost;
  cost.wall_s = bench::time_s(body);
  cost.processor_s = find_processor_s() - before;
  return cost;
}

// The whole of `equilux-analyze report --no-plot`, and the parts of it that grow with answers.
void measure(const std::vector<StudyFolder>& folders, const fs::path& out) {
  AnalyzeParams params;
  for (const StudyFolder& folder : folders) params.study_folders.push_back(folder.root);
  std::vector<Report> reports;
  const Cost load = time_both([&] { reports = load_reports(params); });
  const Cost write = time_both([&] { save_report(make_report_files(reports), out); });
  const Report& report = reports.front();
  const auto& answers = report.evidence.artifact.answers;
  const Cost count = time_both([&] { tally_answers(answers, report.study); });
  ResponseMatrix matrix;
  const Cost arrange = time_both([&] { matrix = make_response_matrix(answers); });
  const Cost disturb = time_both([&] {
    find_uncertainty(report.study, report.findings, matrix, make_response_matrix({}), report.params);
  });
  fmt::print("| {} | {} | {:.2f} / {:.2f} | {:.3f} | {:.3f} | {:.2f} | {:.2f} / {:.2f} | {:.0f} |\n",
             answers.size(), folders.size(), load.wall_s, load.processor_s, count.processor_s,
             arrange.processor_s, disturb.processor_s, write.wall_s, write.processor_s, find_peak_mib());
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
      "| answers | logs | load and judge, s / processor s | tally of it | matrix | resamples | write | peak, "
      "MiB |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t logs : {1, 10, 100}) {
    while (folders.size() < logs) {
      folders.push_back({temporary / std::to_string(folders.size())});
      make_log(folders.back(), study, cells, folders.size());
    }
    measure(folders, temporary / "report");
  }
}

}  // namespace
}  // namespace equilux

int main() { equilux::run(); }
