// timing.json, added to; the log.
#include "renderer/timing.h"

#include <algorithm>
#include <exception>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "base/version.h"
#include "renderer/isa.h"
#include "renderer/parallel.h"
#include "renderer/stopwatch.h"

namespace equilux {
namespace {

Json make_run(const RunTiming& timing) {
  Json seconds;
  for (const auto& [stage, time] : timing.seconds) seconds.set(stage, time);
  Json run;
  run.set("producer_version", kVersion).set("finished_utc", format_utc_now()).set("host", find_host_name());
  run.set("isa", format_isa(current_isa())).set("threads", count_threads());
  run.set("layers_rendered", timing.layers_rendered).set("pictures_written", timing.pictures_written);
  run.set("processor_seconds", timing.processor_seconds).set("peak_memory_bytes", measure_peak_memory());
  run.set("foreseen_work", timing.work).set("seconds", std::move(seconds));
  return run;
}

void save_runs(const StudyFolder& folder, Json runs) {
  Json json;
  json.set("schema", "equilux-timing").set("schema_version", 1).set("runs", std::move(runs));
  save_text(folder.timing(), format_json(json));
}

// Closed where it is no file.
std::ofstream open_log(const StudyFolder& folder) {
  const bool is_writable = is_file(folder.log()) || !path_exists(folder.log());
  return is_writable ? std::ofstream(folder.log(), std::ios::app) : std::ofstream();
}

}  // namespace

void append_timing(const StudyFolder& folder, const RunTiming& timing) {
  Json runs = load_timing(folder);
  runs.push(make_run(timing));
  save_runs(folder, std::move(runs));
}

void join_timing(const StudyFolder& folder, const StudyFolder& share) {
  Json runs = load_timing(folder);
  const Json more = load_timing(share);
  for (const Json& run : more.as_array()) {
    const Json::Array& known = runs.as_array();
    if (std::find(known.begin(), known.end(), run) == known.end()) runs.push(run);
  }
  save_runs(folder, std::move(runs));
}

void join_log(const StudyFolder& folder, const StudyFolder& share) {
  if (!is_file(share.log())) return;  // there is none, or a pipe that would be waited for
  std::ifstream lines(share.log());
  open_log(folder) << lines.rdbuf();
}

WorkLog::WorkLog(const StudyFolder& folder) : file_(open_log(folder)) {}

void WorkLog::add(const std::string& line) { file_ << format_utc_now() << " " << line << std::endl; }

LoggedProduct::LoggedProduct(WorkLog& log, std::string product)
    : log_(log),
      product_(std::move(product)),
      exceptions_(std::uncaught_exceptions()),
      start_(std::chrono::steady_clock::now()),
      processor_start_(measure_processor_seconds()) {}

LoggedProduct::~LoggedProduct() {
  if (std::uncaught_exceptions() > exceptions_) return;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  log_.add(fmt::format("{}: {:.2f} s, {:.2f} s of processors", product_, seconds,
                       measure_processor_seconds() - processor_start_));
}

}  // namespace equilux
