// equilux-analyze: parse, call, report, exit code.
#include <CLI/CLI.hpp>

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
  bool no_verify = false;
};

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
  params.verify = !options.no_verify;
  if (!options.kind.empty()) params.kind = equilux::parse_kind(options.kind, "--kind");
  return params;
}

void add_prune(CLI::App& app, Options& options) {
  CLI::App* prune = app.add_subcommand("prune", "Choose the clamp levels of the material experiment");
  prune->add_option("DIR", options.folders, "Study folder made by equilux-render")->required()->expected(1);
  add_options(prune, options);
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
      ->capture_default_str();
  report->add_option("--draws", options.uncertainty.posterior_draws, "Posterior draws")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  report->add_option("--resamples", options.uncertainty.resamples, "Resamples of subjects")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  report->add_flag("--no-verify", options.no_verify,
                   "Report on pictures that are missing, changed or too noisy too, and say so");
  report->footer("Example:\n  equilux-analyze report studies/pocket --kind planted");
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
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? equilux::kExitOk : equilux::kExitUsage;
  }
  return equilux::run_program("equilux-analyze", [&] {
    const auto params = make_params(options);
    return app.got_subcommand("prune") ? equilux::run_prune(params) : equilux::run_report(params);
  });
}
