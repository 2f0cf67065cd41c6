// equilux-render set, tonemap: the pictures of a study.
#include <fmt/format.h>

#include "base/error.h"
#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/set.h"

namespace equilux {
namespace {

CLI::Validator is_share() {
  const auto check = [](const std::string& text) {
    try {
      parse_job(text);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  return CLI::Validator(check, "I/N");
}

}  // namespace

void add_set(CLI::App& app, CommandLine& line) {
  auto params = std::make_shared<SetParams>();
  CLI::App* set =
      app.add_subcommand("set", "Render and tone-map the stimulus set of a study; goes on where it stopped");
  set->add_option("study", params->study_path, "Study file")->required();
  set->add_option("--out", params->folder, "Study folder to make or complete")->required();
  set->add_option("--only", params->only, "Glob over keys of pictures and references");
  auto job = std::make_shared<std::string>();
  CLI::Option* share =
      set->add_option("--job", *job, "Render this share alone, such as 3/16; `gather` puts them together")
          ->check(is_share());
  set->add_option("--reuse", params->reuse, "Study folders whose layers may be taken over");
  add_machine(*set, line);
  set->footer("Example: equilux-render set protocols/pocket.json --out studies/pocket --only 'G0-MS-*'");
  set->callback([&line, params, job, share] {
    line.command = [params, job, is_share = share->count() > 0] {
      if (is_share) params->job = parse_job(*job);
      params->remark = [](const std::string& why) { fmt::print(stderr, "warning: {}\n", why); };
      const SetSummary summary = make_set(*params);
      fmt::print("{}\n{}\n", format_summary(summary), params->folder.string());
      return is_within_limits(summary) ? kExitOk : kExitError;
    };
  });
}

void add_tonemap(CLI::App& app, CommandLine& line) {
  auto folder = std::make_shared<std::filesystem::path>();
  auto only = std::make_shared<std::string>("*");
  CLI::App* tonemap = app.add_subcommand("tonemap", "Make the pictures of a study folder from its layers");
  tonemap->add_option("folder", *folder, "Study folder")->required();
  tonemap->add_option("--only", *only, "Glob over keys of pictures and references");
  tonemap->footer("Example: equilux-render tonemap studies/pocket");
  tonemap->callback([&line, folder, only] {
    line.command = [folder, only] {
      const SetSummary summary = tonemap_set(*folder, *only);
      fmt::print("{}", format_summary(summary));
      return is_within_limits(summary) ? kExitOk : kExitError;
    };
  });
}

}  // namespace equilux
