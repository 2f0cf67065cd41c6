// timing.json: times, host and instruction set of every run that made something. No digest covers it.
#pragma once

#include <chrono>
#include <cstddef>
#include <fstream>
#include <map>
#include <optional>
#include <string>

#include "base/json.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// The runs so far; an empty array where there is no file. errors: InputError if it is damaged.
Json load_timing(const StudyFolder& folder);

/// What a run did.
struct RunTiming {
  std::map<std::string, double> seconds;  ///< by stage
  std::size_t layers_rendered = 0, pictures_written = 0;
  double work = 0;               ///< as it was foreseen, of layers. units: paths
  double processor_seconds = 0;  ///< of all threads. units: s
};

/// errors: InputError, StoreError
void append_timing(const StudyFolder& folder, const RunTiming& timing);

/// Adds the runs of a share to those of its set, but for those that are there. errors: InputError, StoreError
void join_timing(const StudyFolder& folder, const StudyFolder& share);

/// Adds the log of a share to that of its set.
void join_log(const StudyFolder& folder, const StudyFolder& share);

/// Work done a second in this folder's runs; empty where none says. units: paths / s
std::optional<double> find_speed(const StudyFolder& folder);

/// render.log: a line for each product as soon as it is whole, with its seconds and those of processors,
/// which tell more where others share the machine. No digest covers it, and what cannot be written there is
/// lost, nor is a pipe waited for: a log stops no work.
class WorkLog {
 public:
  explicit WorkLog(const StudyFolder& folder);
  void add(const std::string& line);

 private:
  std::ofstream file_;
};

/// Logs its product and how long it lived, unless an error ends it.
class LoggedProduct {
 public:
  LoggedProduct(WorkLog& log, std::string product);
  ~LoggedProduct();
  LoggedProduct(const LoggedProduct&) = delete;
  LoggedProduct& operator=(const LoggedProduct&) = delete;

 private:
  WorkLog& log_;
  std::string product_;
  int exceptions_;
  std::chrono::steady_clock::time_point start_;
  double processor_start_;
};

}  // namespace equilux
