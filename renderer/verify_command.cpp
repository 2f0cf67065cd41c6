// equilux-render verify: what a set lacks.
#include <fmt/format.h>

#include "base/error.h"
#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/jobs.h"
#include "renderer/submit.h"
#include "renderer/verify.h"
#include "stimuli/verdict.h"

namespace equilux {
namespace {

struct VerifyOptions {
  std::filesystem::path folder, study;
  int jobs = 0;  // 0: not rendered in shares
};

// Shares that failed or were lost.
std::vector<Finding> find_lost_shares(const VerifyOptions& options) {
  if (options.jobs == 0) return {};
  SubmitParams params;
  params.study_path = options.study;
  params.folder = options.folder;
  params.count = options.jobs;
  std::vector<Finding> findings;
  try {  // the boundary to what else was found
    for (const int index : find_unfinished(params))
      findings.push_back({fmt::format("share {} of {}", index, options.jobs),
                          "not whole; `equilux-render submit` with this number renders what it lacks", true});
  } catch (const InputError& error) {
    findings.push_back({"shares", error.what(), true});
  }
  return findings;
}

// A folder that is only to be read can be verified too, and one whose earlier verdict is damaged.
void record(const VerifyOptions& options, std::vector<Finding>& findings) {
  try {
    findings = renew_verdict({options.folder}, findings, !options.study.empty());
  } catch (const StoreError& error) {
    fmt::print(stderr, "what was found is not recorded: {}\n", error.what());
  } catch (const InputError& error) {
    findings.push_back({"verdict", fmt::format("{}; `verify --study` writes it anew", error.what())});
  }
}

int run_verify(const VerifyOptions& options) {
  Verification set =
      verify_set(options.folder, options.study.empty() ? std::nullopt : std::optional(options.study));
  const auto lost = find_lost_shares(options);
  set.findings.insert(set.findings.end(), lost.begin(), lost.end());
  record(options, set.findings);
  for (const Finding& finding : set.findings) fmt::print("{}\n", format_finding(finding));
  for (const std::string& note : set.notes) fmt::print("note: {}\n", note);
  fmt::print("{}: {} pictures and {} layers, {}\n", options.folder.string(), set.pictures, set.layers,
             set.findings.empty() ? std::string("whole") : fmt::format("{} findings", set.findings.size()));
  return set.findings.empty() ? kExitOk : kExitError;
}

}  // namespace

void add_verify(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<VerifyOptions>();
  CLI::App* verify =
      app.add_subcommand("verify", "Check that a set is whole, consistent and within its limits");
  verify->add_option("folder", options->folder, "Study folder")->required();
  verify->add_option("--study", options->study,
                     "Study file, to check that each layer was made from it and its scene");
  verify
      ->add_option("--jobs", options->jobs,
                   "Shares that it was rendered in, to tell which failed or were lost")
      ->check(CLI::Range(1, kMostJobs))
      ->needs("--study");
  add_machine(*verify, line);
  verify->footer("Example: equilux-render verify studies/pocket --study protocols/pocket.json");
  verify->callback([&line, options] { line.command = [options] { return run_verify(*options); }; });
}

}  // namespace equilux
