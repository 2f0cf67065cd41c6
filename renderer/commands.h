// The subcommands of equilux-render: each adds itself to the command line and says there what it will do.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace equilux {

/// What the words of one call come to.
struct CommandLine {
  std::function<int()> command;  ///< of the subcommand that was named; gives the exit code
  int threads = 0;               ///< 0 for all cores
  std::string isa;               ///< empty for the best that the processor has
};

void add_set(CLI::App& app, CommandLine& line);
void add_image(CLI::App& app, CommandLine& line);
void add_tonemap(CLI::App& app, CommandLine& line);
void add_prove(CLI::App& app, CommandLine& line);
void add_stress(CLI::App& app, CommandLine& line);
void add_describe(CLI::App& app, CommandLine& line);
void add_export(CLI::App& app, CommandLine& line);
void add_sheet(CLI::App& app, CommandLine& line);
void add_converge(CLI::App& app, CommandLine& line);
void add_plan(CLI::App& app, CommandLine& line);
void add_gather(CLI::App& app, CommandLine& line);
void add_submit(CLI::App& app, CommandLine& line);
void add_verify(CLI::App& app, CommandLine& line);
void add_explain(CLI::App& app, CommandLine& line);

/// The options --threads and --isa of a subcommand.
void add_machine(CLI::App& subcommand, CommandLine& line);

/// A number of VPLs such as 100k, a clamp level such as C4.
CLI::Validator is_vpls();
CLI::Validator is_clamp();

/// Numbers from `least` to `most`; CLI11's own range lets NaN through.
CLI::Validator is_in_range(double least, double most);

/// Whole numbers that every file can hold; CLI11 alone would wrap or cut others.
CLI::Validator is_seed();

}  // namespace equilux
