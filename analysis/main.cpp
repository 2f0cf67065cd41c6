// equilux-analyze: parse, call, report, exit code.
#include <CLI/CLI.hpp>
#include <charconv>
#include <fmt/format.h>
#include <limits>

#include "analysis/program.h"
#include "base/program.h"
#include "base/version.h"

namespace {

struct Options {
  std::vector<std::string> folders;
  std::string out;
  std::string kind;
  std::string rule = "paper";
  equilux::UncertaintyParams uncertainty;
  equilux::SubjectPlanParams plan;
  std::string study;
  std::string prediction;
  bool no_plot = false;
  bool no_verify = false;
  bool force = false;
};

template <typename T>
bool is_within(const std::string& text, T least, T most) {
  T value{};
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  return error == std::errc() && end == last && value >= least && value <= most;
}

// CLI::Range takes a whole number that is too large for the largest one, and lets pass what is not a number.
template <typename T>
CLI::Validator check_within(T least, T most) {
  const std::string range = fmt::format("{} to {}", least, most);
  return CLI::Validator(
      [=](std::string& text) {
        return is_within(text, least, most) ? std::string()
                                            : fmt::format("Value {} not in range {}", text, range);
      },
      range);
}

// What report.json, whose numbers are signed, can hold.
CLI::Validator check_seed() {
  return check_within(std::int64_t{0}, std::numeric_limits<std::int64_t>::max());
}

void add_options(CLI::App* command, Options& options) {
  command->add_option("--rule", options.rule, "What decides where a column is not monotone")
      ->check(CLI::IsMember({"paper", "isotonic"}))
      ->capture_default_str();
  command->add_option("--kind", options.kind, "Whose answers (default: the only kind with finished sessions)")
      ->check(CLI::IsMember({"person", "planted", "looking"}));
}

equilux::AnalyzeParams make_params(const Options& options) {
  equilux::AnalyzeParams params;
  params.study_folders = {options.folders.begin(), options.folders.end()};
  params.out = options.out;
  params.uncertainty = options.uncertainty;
  params.rule = equilux::parse_rule(options.rule, "--rule");
  params.plot = !options.no_plot;
  params.verify = !options.no_verify;
  params.force = options.force;
  if (!options.kind.empty()) params.kind = equilux::parse_kind(options.kind, "--kind");
  return params;
}

void add_prune(CLI::App& app, Options& options) {
  CLI::App* prune = app.add_subcommand("prune", "Choose the clamp levels of the material experiment");
  prune->add_option("DIR", options.folders, "Study folder made by equilux-render")->required()->expected(1);
  add_options(prune, options);
  prune->add_flag("--no-verify", options.no_verify, "Also by answers about pictures that do not verify");
  prune->footer("Example:\n  equilux-analyze prune studies/pocket --rule paper --kind planted");
}

void add_report(CLI::App& app, Options& options) {
  CLI::App* report = app.add_subcommand("report", "Write report/ and print whether equivalence exists");
  report
      ->add_option("DIR", options.folders,
                   "Study folders: those of one study are pooled, other studies stand beside it")
      ->required();
  add_options(report, options);
  report->add_option("--out", options.out, "Folder of the report (default: report/ in the first DIR)");
  report->add_option("--seed", options.uncertainty.seed, "Seed of draws and resamples")
      ->check(check_seed())
      ->capture_default_str();
  report->add_option("--draws", options.uncertainty.posterior_draws, "Posterior draws")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  report->add_option("--resamples", options.uncertainty.resamples, "Resamples of subjects")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  report->add_flag("--no-plot", options.no_plot, "Draw no figures; gnuplot is then not needed");
  report->add_flag("--force", options.force, "Replace files of these names that no report wrote");
  report->add_flag("--no-verify", options.no_verify,
                   "Report on pictures that are missing, changed or too noisy too, and say so");
  report->footer("Example:\n  equilux-analyze report studies/pocket --kind planted");
}

void add_export(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand("export", "Write every answer that counts as a row of answers.csv");
  command->add_option("DIR", options.folders, "Study folders, as for report")->required();
  add_options(command, options);
  command->add_option("--out", options.out, "Folder of answers.csv")->required();
  command->add_flag("--no-verify", options.no_verify, "Take answers about pictures that do not verify too");
  command->add_flag("--force", options.force, "Replace an earlier export");
  command->footer("Example:\n  equilux-analyze export studies/pocket --kind planted --out answers");
}

void add_plan(CLI::App& app, Options& options) {
  CLI::App* plan = app.add_subcommand("plan", "Simulate how many subjects a study needs");
  plan->add_option("STUDY", options.study, "Study file or study folder; its truth.json is what is simulated")
      ->required();
  plan->add_option("--rule", options.rule, "What decides where a column is not monotone")
      ->check(CLI::IsMember({"paper", "isotonic"}))
      ->capture_default_str();
  plan->add_option("--subjects", options.plan.subjects,
                   "Numbers of subjects, in each experiment unless --material-subjects says other")
      ->delimiter(',')
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  plan->add_option("--material-subjects", options.plan.material_subjects,
                   "Numbers in the material experiment: one, or as many as --subjects (default: the same)")
      ->delimiter(',')
      ->check(CLI::Range(1, 10000));
  plan->add_option("--studies", options.plan.studies, "Studies simulated for each number")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  plan->add_option("--slope", options.plan.slope,
                   "Spread of the psychometric function in clamp levels; 0: a step")
      ->check(check_within(0.0, 10.0))
      ->capture_default_str();
  plan->add_option("--seed", options.plan.seed, "Seed of the simulation")
      ->check(check_seed())
      ->capture_default_str();
  plan->add_option("--out", options.out,
                   "Folder of plan.csv, plan.json, plan.svg and plan.pdf (default: none)");
  plan->footer("Example:\n  equilux-analyze plan protocols/pocket.json --subjects 8,12,16,24");
}

void add_windows(CLI::App& app, Options& options) {
  CLI::App* windows = app.add_subcommand("windows", "Choose the four clamp levels of each column");
  windows->add_option("DIR", options.folders, "Study folder with a pilot's answers")->required()->expected(1);
  add_options(windows, options);
  windows->add_option("--predicted", options.prediction,
                      "CSV with the columns column, clamp, proportion, in place of answers");
  windows->add_flag("--no-verify", options.no_verify, "Also by answers about pictures that do not verify");
  windows->add_option("--out", options.out, "The new windows.json")->required();
  windows->footer("Example:\n  equilux-analyze windows studies/pocket --kind planted --out windows.json");
}

int run(const CLI::App& app, Options& options) {
  if (app.got_subcommand("plan")) {
    options.plan.rule = equilux::parse_rule(options.rule, "--rule");
    return equilux::run_plan(options.study, options.plan, options.out);
  }
  const auto params = make_params(options);
  if (app.got_subcommand("prune")) return equilux::run_prune(params);
  if (app.got_subcommand("export")) return equilux::run_export(params);
  if (app.got_subcommand("windows")) return equilux::run_windows(params, options.prediction);
  return equilux::run_report(params);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Equilux: from answers to tables, graphs and a report", "equilux-analyze");
  app.set_version_flag("--version", std::string("equilux-analyze ") + equilux::kVersion);
  app.require_subcommand(1);
  app.footer("Example:\n  equilux-analyze report studies/pocket");
  Options options;
  add_prune(app, options);
  add_report(app, options);
  add_export(app, options);
  add_plan(app, options);
  add_windows(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? equilux::kExitOk : equilux::kExitUsage;
  }
  return equilux::run_program("equilux-analyze", [&] { return run(app, options); });
}
