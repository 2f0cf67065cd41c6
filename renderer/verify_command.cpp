// equilux-render verify: what a set lacks.
#include <fmt/format.h>

#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/verify.h"

namespace equilux {

void add_verify(CLI::App& app, CommandLine& line) {
  auto folder = std::make_shared<std::filesystem::path>();
  auto study = std::make_shared<std::filesystem::path>();
  CLI::App* verify =
      app.add_subcommand("verify", "Check that a set is whole, consistent and within its limits");
  verify->add_option("folder", *folder, "Study folder")->required();
  verify->add_option("--study", *study,
                     "Study file, to check that each layer was made from it and its scene");
  verify->footer("Example: equilux-render verify studies/pocket --study protocols/pocket.json");
  verify->callback([&line, folder, study] {
    line.command = [folder, study] {
      const Verification set = verify_set(*folder, study->empty() ? std::nullopt : std::optional(*study));
      for (const Finding& finding : set.findings) fmt::print("{}\n", format_finding(finding));
      fmt::print(
          "{}: {} pictures and {} layers, {}\n", folder->string(), set.pictures, set.layers,
          set.findings.empty() ? std::string("whole") : fmt::format("{} findings", set.findings.size()));
      return set.findings.empty() ? kExitOk : kExitError;
    };
  });
}

}  // namespace equilux
