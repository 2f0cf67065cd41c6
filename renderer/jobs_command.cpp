// equilux-render plan, gather, submit: a set in shares.
#include <algorithm>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/memory.h"
#include "base/program.h"
#include "base/progress.h"
#include "protocols/windows.h"
#include "renderer/commands.h"
#include "renderer/jobs.h"
#include "renderer/set.h"
#include "renderer/set_space.h"
#include "renderer/submit.h"
#include "renderer/timing.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

struct PlanOptions {
  fs::path study, folder;
  std::string only = "*";
  int jobs = 1;
};

// Work a second, and where it is known from.
std::pair<double, std::string> find_rate(const PlanOptions& options, const Study& study, const Scene& scene) {
  if (!options.folder.empty()) {
    const std::string file = StudyFolder{options.folder}.timing().string();
    if (const auto speed = find_speed({options.folder})) return {*speed, "as in " + file};
    return {measure_speed(study, scene), "measured now on this machine; " + file + " tells of no work"};
  }
  return {
      measure_speed(study, scene),
      "measured now on this machine; costs are those of the café, in other rooms --out tells more once some "
      "of it is rendered"};
}

// What the folder lacks.
std::string tell_rest(const PlanOptions& options, const Study& study, const Scene& scene,
                      const Wanted& wanted, const std::map<WorldKey, WorldCosts>& costs, double speed) {
  LayerStore store({options.folder}, study);
  const Wanted missing = find_missing(make_recipes(study, scene, wanted), wanted, store);
  const std::string folder = options.folder.string();
  if (missing.empty()) return fmt::format("All of it is rendered in {}.\n", folder);
  return fmt::format(
      "Not yet in {}: {} references and {} layers of VPL pictures, foreseen {}{}.\n", folder,
      missing.families.size(), missing.conditions.size(),
      format_seconds(sum_work(list_work(costs, missing)) / speed),
      has_shares({options.folder}) ? "; it has shares, which are not counted until gathered" : "");
}

// Where there are more shares than objects in a view the last ones have nothing.
std::string tell_empty_shares(const std::vector<std::vector<WorkItem>>& jobs) {
  const auto first =
      std::find_if(jobs.begin(), jobs.end(), [](const std::vector<WorkItem>& job) { return job.empty(); });
  if (first == jobs.end()) return "";
  const auto number = first - jobs.begin() + 1, last = std::ssize(jobs);
  const std::string which =
      number == last ? fmt::format("{}/{}", last, last) : fmt::format("{} to {}/{}", number, last, last);
  return fmt::format("{:<12}{:>12}{:>14}{:>10}  nothing\n", which, 0, 0, "0 s");
}

int run_plan(const PlanOptions& options) {
  const Study study = load_study(options.study);
  const Scene scene = load_scene(study.scene_path);
  const Wanted wanted = enumerate_wanted(study, options.only);
  const bool is_own = !options.folder.empty() && load_folder_study({options.folder}).digest == study.digest;
  if (!is_own) load_windows(study.windows_path, study);  // as `set` will
  const auto costs = estimate_worlds(study, scene, wanted);
  const auto jobs = split_work(list_work(costs, wanted), options.jobs);
  const auto [speed, source] = find_rate(options, study, scene);
  fmt::print("{}: {} references, {} VPL pictures in {} shares\n\n", study.name, wanted.families.size(),
             wanted.conditions.size(), options.jobs);
  fmt::print("{:<12}{:>12}{:>14}{:>10}  {}\n", "job", "references", "VPL pictures", "foreseen", "from, to");
  double longest = 0, sum = 0;
  for (std::size_t i = 0; i < jobs.size() && !jobs[i].empty(); ++i) {
    const Wanted share = join_work(jobs[i]);
    const double seconds = sum_work(jobs[i]) / speed;
    longest = std::max(longest, seconds);
    sum += seconds;
    fmt::print("{:<12}{:>12}{:>14}{:>10}  {}, {}\n", fmt::format("{}/{}", i + 1, jobs.size()),
               share.families.size(), share.conditions.size(), fmt::format("{:.0f} s", seconds),
               format_key(jobs[i].front().family), format_key(jobs[i].back().family));
  }
  fmt::print("{}", tell_empty_shares(jobs));
  fmt::print(
      "\nThe longest {}, all one after another {}, their pictures {} more; {:.3g} paths a second, {}.\n",
      format_seconds(longest), format_seconds(sum), format_seconds(cost_of_pictures(study, wanted) / speed),
      speed, source);
  fmt::print("All of it takes about {} of a disk.\n", format_bytes(estimate_set_bytes(study, costs, wanted)));
  if (const std::string narrow = tell_narrow_target(study); !narrow.empty())
    fmt::print("warning: {}\n", narrow);
  if (is_own) {
    fmt::print("{}", tell_rest(options, study, scene, wanted, costs, speed));
  } else if (!options.folder.empty()) {
    fmt::print("{} is the folder of another study: its layers are not looked at.\n", options.folder.string());
  }
  return kExitOk;
}

struct SubmitOptions {
  SubmitParams params;
  std::string engine = "slurm";
  bool dry_run = false;
};

// Lines of a script are made of them.
void check_words(const SubmitParams& params) {
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; };
  for (const std::string& option : params.options) {
    if (option.empty() || option[0] == '-' || std::any_of(option.begin(), option.end(), is_control))
      throw InputError("--sbatch", "", "an option without dashes, such as time=2:00:00", option);
  }
  const fs::path& folder = params.folder;
  // Of the names of logs Slurm reads one as a sign.
  if (folder.string().find('\\') != std::string::npos)
    throw InputError("--out", "", "a folder without a backslash in its name", "\"" + folder.string() + "\"");
  if (folder.empty() || (path_exists(folder) && !fs::is_directory(folder)))
    throw InputError("--out", "", "a folder, or the name of one to make", "\"" + folder.string() + "\"");
}

int run_submit(const SubmitOptions& options, const CommandLine& line) {
  SubmitParams params = options.params;
  check_words(params);
  params.isa = current_isa();  // the best of this machine, or the one that was asked for
  params.threads = line.threads;
  params.program = fs::canonical("/proc/self/exe");
  params.study_path = fs::absolute(params.study_path);
  params.folder = fs::absolute(params.folder);
  std::vector<int> unfinished = find_unfinished(params);
  for (const int index : find_running(params, unfinished)) {
    fmt::print(
        "share {} of {} is being rendered: not submitted again; what is missing when its job has ended, "
        "submit then\n",
        index, params.count);
    std::erase(unfinished, index);
  }
  if (const std::string others = tell_other_shares(params); !others.empty()) fmt::print("{}\n", others);
  const SlurmJobs jobs = make_slurm_jobs(params, std::move(unfinished));
  fmt::print("{} of {} shares to render\n", jobs.indices.size(), params.count);
  if (options.dry_run) {
    for (const std::string& command : format_sbatch(jobs)) fmt::print("{}\n", command);
    fmt::print("\n{}:\n{}\n{}:\n{}", jobs.array_script.string(), jobs.array_text, jobs.gather_script.string(),
               jobs.gather_text);
    return kExitOk;
  }
  save_scripts(jobs);
  submit_slurm(jobs, [](const std::string& number) {
    fmt::print("job {}\n", number);
    std::fflush(stdout);
  });
  return kExitOk;
}

CLI::Validator is_job_count() { return CLI::Range(1, kMostJobs); }

}  // namespace

void add_plan(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* plan =
      app.add_subcommand("plan", "Foresee how long a stimulus set takes, in shares of equal cost");
  plan->add_option("study", options->study, "Study file")->required();
  plan->add_option("--jobs", options->jobs, "Shares (1)")->check(is_job_count());
  plan->add_option("--only", options->only, "Glob over keys of pictures and references");
  plan->add_option("--out", options->folder,
                   "Study folder: its times tell the speed of its machines, its layers what is left");
  add_machine(*plan, line);
  plan->footer("Example: equilux-render plan protocols/paper.json --jobs 16");
  plan->callback([&line, options] { line.command = [options] { return run_plan(*options); }; });
}

void add_gather(CLI::App& app, CommandLine& line) {
  auto params = std::make_shared<SetParams>();
  params->render = false;
  CLI::App* gather =
      app.add_subcommand("gather", "Put shares that `set --job` rendered together, and tone-map the set");
  gather->add_option("study", params->study_path, "Study file")->required();
  gather->add_option("--out", params->folder, "Study folder")->required();
  add_machine(*gather, line);
  gather->footer("Example: equilux-render gather protocols/pocket.json --out studies/pocket");
  gather->callback([&line, params] {
    line.command = [params] {
      const SetSummary summary = make_set(*params);
      fmt::print("{}\n{}\n", format_summary(summary), params->folder.string());
      return is_within_limits(summary) ? kExitOk : kExitError;
    };
  });
}

void add_submit(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<SubmitOptions>();
  CLI::App* submit =
      app.add_subcommand("submit", "Give the shares that lack something to a cluster, and gather them after");
  submit->add_option("study", options->params.study_path, "Study file")->required();
  submit->add_option("--out", options->params.folder, "Study folder that every machine sees")->required();
  submit->add_option("--jobs", options->params.count, "Shares; the same number as before, to go on")
      ->required()
      ->check(is_job_count());
  submit->add_option("--engine", options->engine, "Batch system (slurm)")->check(CLI::IsMember({"slurm"}));
  submit->add_option("--sbatch", options->params.options,
                     "Options of sbatch without dashes, such as time=2:00:00");
  submit->add_flag("--dry-run", options->dry_run, "Print the scripts and commands, submit nothing");
  add_machine(*submit, line);
  submit->footer(
      "Example: equilux-render submit protocols/paper.json --out studies/paper --jobs 16 --isa v3");
  submit->callback(
      [&line, options] { line.command = [options, &line] { return run_submit(*options, line); }; });
}

}  // namespace equilux
