// A set spread over the machines of a cluster by its batch system.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "renderer/isa.h"

namespace equilux {

struct SubmitParams {
  std::filesystem::path program;  ///< equilux-render, as the machines of the cluster find it
  std::filesystem::path study_path, folder;
  int count = 1;  ///< of shares
  /// Of all jobs: where each took its machine's best, neither their bytes nor their shares would fit
  /// together.
  Isa isa = current_isa();
  int threads = 0;                   ///< 0: as many as Slurm gives the step
  std::vector<std::string> options;  ///< of sbatch, without dashes, for both steps
};

/// What is handed to Slurm: an array of the shares that lack something, and a step after it that gathers.
struct SlurmJobs {
  std::vector<int> indices;  ///< of shares, rising; empty where all that is missing is to gather
  std::filesystem::path array_script, gather_script;
  std::string array_text, gather_text;
};

/// Shares whose layers are neither in the set's folder nor in their own.
/// errors: InputError for what study or scene lack
std::vector<int> find_unfinished(const SubmitParams& params);

/// Says that shares of another number stand in the folder, whose layers find_unfinished does not count; empty
/// where there are none.
std::string tell_other_shares(const SubmitParams& params);

/// Those of them that a process renders at this moment. errors: StoreError
std::vector<int> find_running(const SubmitParams& params, const std::vector<int>& indices);

SlurmJobs make_slurm_jobs(const SubmitParams& params, std::vector<int> indices);

/// Writes the scripts. errors: StoreError
void save_scripts(const SlurmJobs& jobs);

/// The two calls of sbatch; "JOB" stands for the array's number.
std::vector<std::string> format_sbatch(const SlurmJobs& jobs);

/// Calls sbatch; `tell` gets the number of each job as soon as it is submitted. errors: InputError if sbatch
/// is not there or refuses
void submit_slurm(const SlurmJobs& jobs, const std::function<void(const std::string&)>& tell);

}  // namespace equilux
