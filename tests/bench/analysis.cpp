// What the way from logs to tables costs: time and memory against the number of answers.
#include <fmt/format.h>
#include <sys/resource.h>

#include "analysis/evidence.h"
#include "analysis/program.h"
#include "analysis/prune.h"
#include "base/files.h"
#include "base/random.h"
#include "protocols/windows.h"
#include "tests/bench/bench.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// Of 480 trials, after which material sessions come until a log has its answers.
constexpr int kArtifactSubjects = 14;
constexpr std::size_t kAnswersPerLog = 10'000;

// Artifacts are seen in the two less clamped levels of a column's window, changes of material in its last.
bool is_seen(const Cell& cell, Experiment experiment, const Windows& windows) {
  const int step = cell.clamp_level - windows.by_column.at(cell.column).first_level;
  return experiment == Experiment::kArtifact ? step < 2 : step == kWindowLevels - 1;
}

struct BenchStudy {
  Study study = load_study(EQUILUX_SOURCE_DIR "/protocols/paper.json");
  Windows windows = load_windows(study.windows_path, study);
};

TrialRow make_trial(int number, const Cell& cell, Experiment experiment, const Windows& windows,
                    RandomStream& random) {
  TrialRow trial;
  trial.number = number;
  trial.cell = cell;
  trial.test_key = format_key(Condition{cell, 0});
  trial.pair_key = format_key(Family{cell.column.object, 0});
  if (experiment == Experiment::kMaterial) trial.upper_key = format_key(Family{cell.column.object, 1});
  trial.test_side = random.next_below(2) == 0 ? Side::kLeft : Side::kRight;
  const bool is_right = random.next_below(100) < (is_seen(cell, experiment, windows) ? 95U : 50U);
  trial.answer = (trial.test_side == Side::kLeft) == is_right ? Side::kLeft : Side::kRight;
  trial.response_time_ns = 1'500'000'000;
  trial.answered_utc = "2026-01-31T12:00:00.000Z";
  return trial;
}

// Appends sessions of one experiment, each over all cells; gives their number of answers.
class LogWriter {
 public:
  LogWriter(const BenchStudy& bench, const StudyFolder& folder, std::uint64_t seed)
      : bench_(bench), log_(folder.responses(), true), seed_(seed) {}

  std::size_t append(Experiment experiment, const std::vector<Cell>& cells, const std::string& selection,
                     int subject) {
    RandomStream random(seed_, "bench." + format_experiment(experiment), static_cast<std::uint64_t>(subject));
    std::vector<TrialRow> trials;
    for (std::size_t i = 0; i < cells.size(); ++i)
      trials.push_back(make_trial(static_cast<int>(i), cells[i], experiment, bench_.windows, random));
    SessionRow row;
    row.participant = fmt::format("P{}-{}-{}", seed_, format_experiment(experiment), subject);
    row.experiment = experiment;
    row.subject_index = subject;
    row.program_version = "bench";
    row.digests.study = bench_.study.digest;
    row.digests.selection = selection;
    row.started_utc = "2026-01-31T12:00:00.000Z";
    log_.finish_session(log_.append_session(row, trials), 1);
    return trials.size();
  }

 private:
  const BenchStudy& bench_;
  TrialLog log_;
  std::uint64_t seed_;
};

std::vector<Cell> list_window_cells(const BenchStudy& bench) {
  std::vector<Cell> cells;
  for (const Column& column : enumerate_columns(bench.study)) {
    for (int i = 0; i < kWindowLevels; ++i)
      cells.push_back({column, bench.windows.by_column.at(column).first_level + i, false});
  }
  return cells;
}

Selection prune(const StudyFolder& folder, const Study& study) {
  const Evidence evidence = load_evidence(folder, study, SubjectKind::kPerson);
  const Selection selection = make_selection(study, tally_answers(evidence.artifact.answers, study),
                                             evidence.kind, Rule::kPaper, evidence.artifact.digest);
  save_selection(selection, folder.selection(evidence.kind));
  return selection;
}

void make_log(const StudyFolder& folder, const BenchStudy& bench, std::uint64_t seed) {
  make_folder(folder.root);
  save_text(folder.study(), format_json(bench.study.source));
  LogWriter writer(bench, folder, seed);
  std::size_t answers = 0;
  const auto all = list_window_cells(bench);
  for (int subject = 0; subject < kArtifactSubjects; ++subject)
    answers += writer.append(Experiment::kArtifact, all, "", subject);
  const Selection selection = prune(folder, bench.study);
  const auto left = enumerate_selected_cells(selection, bench.study);
  for (int subject = 0; answers < kAnswersPerLog; ++subject)
    answers += writer.append(Experiment::kMaterial, left, digest_selection(selection), subject);
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
  const auto& artifact = report.evidence.artifact.answers;
  const auto& material = report.evidence.material.answers;
  const Cost count = time_both([&] {
    tally_answers(artifact, report.study);
    tally_answers(material, report.study);
  });
  ResponseMatrix artifact_matrix, material_matrix;
  const Cost arrange = time_both([&] {
    artifact_matrix = make_response_matrix(artifact);
    material_matrix = make_response_matrix(material);
  });
  const Cost disturb = time_both([&] {
    find_uncertainty(report.study, report.findings, artifact_matrix, material_matrix, report.params);
  });
  fmt::print("| {} + {} | {} | {:.2f} / {:.2f} | {:.3f} | {:.3f} | {:.2f} | {:.2f} / {:.2f} | {:.0f} |\n",
             artifact.size(), material.size(), folders.size(), load.wall_s, load.processor_s,
             count.processor_s, arrange.processor_s, disturb.processor_s, write.wall_s, write.processor_s,
             find_peak_mib());
}

// The folders of logs stay in `kept`, to be reported on by `equilux-analyze`; empty: they do not.
void run(const fs::path& kept) {
  const BenchStudy bench;
  const TempFolder temporary;
  const fs::path root = kept.empty() ? temporary.path() : kept;
  std::vector<StudyFolder> folders;
  fmt::print(
      "| artifact + material answers | logs | load and judge, s / processor s | tally of it | matrix | "
      "resamples | write | peak, MiB |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const std::size_t logs : {1, 10, 100}) {
    while (folders.size() < logs) {
      folders.push_back({root / std::to_string(folders.size())});
      make_log(folders.back(), bench, folders.size());
    }
    measure(folders, root / "report");
  }
}

}  // namespace
}  // namespace equilux

int main(int count, char** words) { equilux::run(count > 1 ? words[1] : ""); }
