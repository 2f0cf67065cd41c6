// Scripts that call equilux-render, and sbatch that takes them.
#include "renderer/submit.h"

#include <cstdio>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>

#include "base/error.h"
#include "base/files.h"
#include "base/folder_lock.h"
#include "renderer/jobs.h"
#include "renderer/set_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// One word for a shell, whatever it holds.
std::string quote(const std::string& word) {
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string make_head(const SubmitParams& params, const char* name) {
  std::string text = fmt::format("#!/bin/sh\n#SBATCH --job-name={}\n", name);
  for (const std::string& option : params.options) text += fmt::format("#SBATCH --{}\n", option);
  return text + "set -eu\n";
}

std::string make_call(const SubmitParams& params, const char* verb) {
  return fmt::format("{} {} {} --out {} --isa {}", quote(params.program.string()), verb,
                     quote(params.study_path.string()), quote(params.folder.string()),
                     format_isa(params.isa));
}

// 1-3,7 as Slurm writes arrays.
std::string format_indices(const std::vector<int>& indices) {
  std::string text;
  for (std::size_t i = 0; i < indices.size();) {
    std::size_t last = i;
    while (last + 1 < indices.size() && indices[last + 1] == indices[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ",", indices[i]);
    if (last > i) text += fmt::format("-{}", indices[last]);
    i = last + 1;
  }
  return text;
}

// Slurm puts numbers where a name has a percent sign, unless there are two.
std::string name_log(const fs::path& folder, const char* name) {
  std::string text;
  for (const char c : folder.string()) text += c == '%' ? std::string("%%") : std::string(1, c);
  return quote(text + "/" + name);
}

std::string format_array_call(const SlurmJobs& jobs) {
  return fmt::format("sbatch --parsable --array={} --output={} {}", format_indices(jobs.indices),
                     name_log(jobs.array_script.parent_path(), "%A-%a.log"),
                     quote(jobs.array_script.string()));
}

std::string format_gather_call(const SlurmJobs& jobs, const std::string& after) {
  const std::string dependency = after.empty() ? "" : " --dependency=afterany:" + after;
  return fmt::format("sbatch --parsable{} --output={} {}", dependency,
                     name_log(jobs.gather_script.parent_path(), "%j.log"),
                     quote(jobs.gather_script.string()));
}

// The first line that a command prints, without the cluster's name.
std::string run_sbatch(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw InputError("sbatch", "", "a command that can be run", "none");
  std::string text;
  char buffer[256];
  while (std::fgets(buffer, sizeof buffer, pipe)) text += buffer;
  const int status = pclose(pipe);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw InputError("sbatch", "", "a job that Slurm takes", command + " failed; see above");
  return text.substr(0, text.find_first_of(";\n"));
}

}  // namespace

std::vector<int> find_unfinished(const SubmitParams& params) {
  const Study study = load_study(params.study_path);
  check_own_folders({params.folder});
  check_folder_of(study, {params.folder});
  const Scene scene = load_scene(study.scene_path);
  const Wanted all = enumerate_wanted(study, "*");
  const Recipes recipes = make_recipes(study, scene, all);
  LayerStore store({params.folder}, study);
  check_unchanged({params.folder}, list_layers(recipes, all), store);
  const auto shares = plan_jobs(study, scene, all, params.count);
  std::vector<int> unfinished;
  for (int index = 1; index <= params.count; ++index) {
    const Wanted missing =
        find_missing(recipes, join_work(shares[static_cast<std::size_t>(index - 1)]), store);
    if (missing.empty()) continue;
    LayerStore own({StudyFolder{params.folder}.job(format_job_folder({index, params.count}))}, study);
    if (!find_missing(recipes, missing, own).empty()) unfinished.push_back(index);
  }
  return unfinished;
}

std::string tell_other_shares(const SubmitParams& params) {
  const std::string own = format_job_folder({1, params.count}).substr(1);
  std::vector<std::string> others = list_shares({params.folder});
  std::erase_if(others, [&](const std::string& name) { return name.ends_with(own); });
  if (others.empty()) return "";
  return fmt::format(
      "shares of another number stand in {}: {}; what they hold is not counted, and would be rendered again: "
      "`equilux-render gather {} --out {}` takes it in, submit after that",
      StudyFolder{params.folder}.jobs().string(), fmt::join(others, ", "), quote(params.study_path.string()),
      quote(params.folder.string()));
}

std::vector<int> find_running(const SubmitParams& params, const std::vector<int>& indices) {
  std::vector<int> running;
  for (const int index : indices) {
    const fs::path share = StudyFolder{params.folder}.job(format_job_folder({index, params.count}));
    if (fs::exists(share) && FolderLock(share).is_busy()) running.push_back(index);
  }
  return running;
}

SlurmJobs make_slurm_jobs(const SubmitParams& params, std::vector<int> indices) {
  SlurmJobs jobs;
  jobs.indices = std::move(indices);
  const fs::path folder = params.folder / "slurm";
  jobs.array_script = folder / "array.sh";
  jobs.gather_script = folder / "gather.sh";
  jobs.array_text =
      make_head(params, "equilux") + make_call(params, "set") +
      fmt::format(" --threads {} --job \"$SLURM_ARRAY_TASK_ID/{}\"\n",
                  params.threads > 0 ? std::to_string(params.threads) : "\"${SLURM_CPUS_PER_TASK:-0}\"",
                  params.count);
  jobs.gather_text =
      make_head(params, "equilux-gather") + "failed=0\n" + make_call(params, "gather") +
      fmt::format(" || failed=1\n{} verify {} --study {} --jobs {} --isa {} || failed=1\nexit $failed\n",
                  quote(params.program.string()), quote(params.folder.string()),
                  quote(params.study_path.string()), params.count, format_isa(params.isa));
  return jobs;
}

void save_scripts(const SlurmJobs& jobs) {
  make_folder(jobs.array_script.parent_path());
  save_text(jobs.array_script, jobs.array_text);
  save_text(jobs.gather_script, jobs.gather_text);
}

std::vector<std::string> format_sbatch(const SlurmJobs& jobs) {
  if (jobs.indices.empty()) return {format_gather_call(jobs, "")};
  return {format_array_call(jobs), format_gather_call(jobs, "JOB")};
}

void submit_slurm(const SlurmJobs& jobs, const std::function<void(const std::string&)>& tell) {
  std::string array;
  if (!jobs.indices.empty()) {
    array = run_sbatch(format_array_call(jobs));
    tell(array);
  }
  tell(run_sbatch(format_gather_call(jobs, array)));
}

}  // namespace equilux
