// equilux-render stress: stiff and extreme cases, what each should give and what it gives.
#include <fmt/format.h>

#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/stress.h"

namespace equilux {
namespace {

int write_stress() {
  std::vector<StressRow> rows;
  for (const auto& part :
       {stress_materials, +[] { return stress_vpls(); }, stress_lightcuts, stress_scenes, stress_pictures}) {
    const auto more = part();
    rows.insert(rows.end(), more.begin(), more.end());
  }
  fmt::print("{}", format_stress(rows));
  std::size_t failed = 0;
  for (const StressRow& row : rows) failed += row.outcome == StressOutcome::kFails;
  fmt::print("\n{} rows, {} fail\n", rows.size(), failed);
  return failed > 0 ? kExitError : kExitOk;
}

}  // namespace

void add_stress(CLI::App& app, CommandLine& line) {
  CLI::App* stress =
      app.add_subcommand("stress", "Run stiff and extreme cases; exit status 1 if one of them fails");
  add_machine(*stress, line);
  stress->footer("Example: equilux-render stress > docs/stability-table.md");
  stress->callback([&line] { line.command = write_stress; });
}

}  // namespace equilux
