// equilux-session: runs subjects, persons or planted ones, through the experiments of a study folder.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <fmt/format.h>

#include "base/error.h"
#include "base/program.h"
#include "base/version.h"
#include "experiment/log_commands.h"
#include "experiment/open_session.h"
#include "experiment/simulate.h"
#ifdef EQUILUX_WINDOW
#include "experiment/app/app.h"
#endif

namespace equilux {
namespace {

struct SimulateOptions {
  std::string folder;
  std::string experiment;
  std::optional<int> subjects;
  std::optional<std::int64_t> seed;
  std::optional<std::string> truth;
  bool acknowledge = false;
};

struct RunOptions {
  std::string folder;
  std::string experiment;
  std::string participant;
  std::string monitor;
  bool windowed = false;
  double diagonal_inches = 0;
  double distance_cm = 0;
  bool asks_setup = false;
  double text_scale = 1;
  std::string station;
  std::optional<std::int64_t> planted_seed;
  double pace = 1;
};

struct BrowseOptions {
  std::string folder;
  std::string study;
  std::string monitor;
  double text_scale = 1;
};

void print_acknowledgement(std::int64_t session, int trial) {
  fmt::print("answered {} {}\n", session, trial);
  std::fflush(stdout);
}

int simulate(const SimulateOptions& options) {
  const StudyFolder folder{options.folder};
  const Study study = load_folder_study(folder);
  SimulateParams params;
  params.experiment = parse_experiment(options.experiment, "--experiment");
  params.subjects = options.subjects.value_or(study.subjects.at(options.experiment));
  params.seed = options.seed ? static_cast<std::uint64_t>(*options.seed) : study.seed;
  if (options.truth) params.truth = *options.truth;
  if (options.acknowledge) params.acknowledge = print_acknowledgement;
  const SimulateCounts counts = simulate_subjects(folder, params);
  fmt::print("{} sessions of planted subjects, seed {}: {} kept, {} resumed, {} added\n", options.experiment,
             params.seed, counts.kept, counts.resumed, counts.added);
  return kExitOk;
}

#ifdef EQUILUX_WINDOW
int run(const RunOptions& options) {
  AppParams params;
  params.study_folder = options.folder;
  if (!options.experiment.empty()) params.experiment = parse_experiment(options.experiment, "--experiment");
  params.participant = options.participant;
  params.monitor = options.monitor;
  params.windowed = options.windowed;
  params.diagonal_m = options.diagonal_inches * 0.0254;
  params.viewing_distance_m = options.distance_cm / 100;
  params.asks_setup = options.asks_setup;
  params.text_scale = options.text_scale;
  if (!options.station.empty()) params.lane = parse_lane(options.station, "--station");
  if (options.planted_seed) params.planted_seed = static_cast<std::uint64_t>(*options.planted_seed);
  params.pace = options.pace;
  return run_app(params);
}

int browse(const BrowseOptions& options) {
  return run_browser({options.folder, options.study, options.monitor, options.text_scale});
}
#else
int browse(const BrowseOptions&) {
  throw InputError("browse", "", "a build with a window (EQUILUX_WINDOW=ON)", "a build without one");
}

int run(const RunOptions&) {
  throw InputError("run", "", "a build with a window (EQUILUX_WINDOW=ON)", "a build without one");
}
#endif

void add_simulate(CLI::App& app, SimulateOptions& options) {
  CLI::App* command = app.add_subcommand("simulate", "Planted subjects take the place of persons");
  command->add_option("folder", options.folder, "Study folder")->required()->type_name("DIR");
  command->add_option("--experiment", options.experiment, "Which experiment")
      ->required()
      ->check(CLI::IsMember({"artifact", "material"}));
  command->add_option("--subjects", options.subjects, "Sessions wanted; the study's number if not given")
      ->type_name("N")
      ->check(CLI::Range(1, 100000));
  command->add_option("--seed", options.seed, "Of the subjects; the study's if not given")
      ->type_name("S")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--truth", options.truth, "Planted thresholds; the folder's truth.json if not given")
      ->type_name("FILE");
  command->add_flag("--acknowledge", options.acknowledge,
                    "Print `answered SESSION TRIAL` as soon as an answer is on the disk");
  command->footer("Example: equilux-session simulate studies/pocket --experiment artifact --subjects 12");
}

void add_run(CLI::App& app, RunOptions& options) {
  CLI::App* command =
      app.add_subcommand("run", "A person in front of the window; what is not given is asked");
  command->add_option("folder", options.folder, "Study folder")->type_name("DIR");
  command->add_option("--experiment", options.experiment, "Which experiment")
      ->check(CLI::IsMember({"artifact", "material"}));
  command
      ->add_option("--participant", options.participant,
                   "Code of the participant, the same to go on; `new` draws one")
      ->type_name("CODE");
  command->add_option("--monitor", options.monitor, "Name of the monitor; the primary one if not given")
      ->type_name("NAME");
  command->add_flag("--windowed", options.windowed, "A window in place of the full screen");
  command->add_option("--diagonal", options.diagonal_inches, "Of the visible screen, measured")
      ->type_name("INCHES")
      ->check(CLI::Range(1.0, 1000.0));
  command
      ->add_option("--distance", options.distance_cm,
                   "From the eyes to the screen, measured; the study's if not given")
      ->type_name("CM")
      ->check(CLI::Range(1.0, 10000.0));
  command->add_option("--station", options.station, "The K-th of N stations whose logs will be merged")
      ->type_name("K/N");
  command->add_flag("--setup", options.asks_setup, "Show the set-up screen: size of the screen, distance");
  command->add_option("--text-scale", options.text_scale, "Of all text")
      ->type_name("FACTOR")
      ->check(CLI::Range(0.5, 3.0));
  command
      ->add_option("--planted", options.planted_seed,
                   "A planted subject of this seed answers in a person's place")
      ->type_name("SEED")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--pace", options.pace, "Of the planted response times; 0 answers at once")
      ->type_name("FACTOR")
      ->check(CLI::Range(0.0, 10.0))
      ->needs("--planted");
  command->footer("Example: equilux-session run studies/pocket --experiment artifact --participant P01");
}

void add_browse(CLI::App& app, BrowseOptions& options) {
  CLI::App* command = app.add_subcommand("browse", "Look at a set, move windows, render what is missing");
  command->add_option("folder", options.folder, "Study folder")->required()->type_name("DIR");
  command->add_option("--study", options.study, "From which missing pictures are rendered")
      ->type_name("FILE")
      ->check(CLI::ExistingFile);
  command->add_option("--monitor", options.monitor, "Name of the monitor; the primary one if not given")
      ->type_name("NAME");
  command->add_option("--text-scale", options.text_scale, "Of all text")
      ->type_name("FACTOR")
      ->check(CLI::Range(0.5, 3.0));
  command->footer("Example: equilux-session browse studies/pocket --study protocols/pocket.json");
}

int run_command_line(int argc, char** argv) {
  CLI::App app("Runs subjects through the experiments of a study folder.", "equilux-session");
  app.set_version_flag("--version", std::string("equilux-session ") + kVersion);
  app.require_subcommand(1);
  app.footer("Example: equilux-session status studies/pocket");
  SimulateOptions simulate_options;
  RunOptions run_options;
  BrowseOptions browse_options;
  add_simulate(app, simulate_options);
  add_run(app, run_options);
  add_browse(app, browse_options);
  const LogCommands log_commands(app);
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on file size then fails a write, as a full disk does
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  if (app.got_subcommand("simulate")) return simulate(simulate_options);
  if (app.got_subcommand("run")) return run(run_options);
  if (app.got_subcommand("browse")) return browse(browse_options);
  return log_commands.run().value_or(kExitUsage);
}

}  // namespace
}  // namespace equilux

int main(int argc, char** argv) {
  return equilux::run_program("equilux-session", [&] { return equilux::run_command_line(argc, argv); });
}
