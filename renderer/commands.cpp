// Options that several subcommands share.
#include "renderer/commands.h"

#include <fmt/format.h>

#include "protocols/condition.h"

namespace equilux {

void add_machine(CLI::App& subcommand, CommandLine& line) {
  subcommand.add_option("--threads", line.threads, "Threads; 0 for all cores")->check(CLI::Range(0, 4096));
  subcommand
      .add_option("--isa", line.isa,
                  "Instruction set, v3 (AVX2) or v4 (AVX-512), for the same bytes on any machine that has it "
                  "(the best)")
      ->check(CLI::IsMember({"v3", "v4"}));
}

CLI::Validator is_vpls() {
  return CLI::Validator(
      [](const std::string& text) {
        return is_vpl_count(text) ? std::string()
                                  : fmt::format("expected a count such as 1k, 100k or 5M, got {}", text);
      },
      "COUNT", "vpls");
}

CLI::Validator is_clamp() {
  std::vector<std::string> levels;
  for (int level = 0; level < kClampLevelCount; ++level) levels.push_back(format_clamp(level));
  return CLI::IsMember(levels);
}

CLI::Validator is_in_range(double least, double most) {
  return CLI::Validator(
      [least, most](const std::string& text) {
        double value = 0;
        const bool fits = CLI::detail::lexical_cast(text, value) && value >= least && value <= most;
        return fits ? std::string() : fmt::format("expected {} to {}, got {}", least, most, text);
      },
      fmt::format("{} to {}", least, most), "range");
}

CLI::Validator is_seed() {
  return CLI::Validator(
      [](const std::string& text) {
        const std::string largest = "9223372036854775807";
        const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        const bool fits = text.size() < largest.size() || (text.size() == largest.size() && text <= largest);
        return digits && fits ? std::string() : fmt::format("expected 0 to {}, got {}", largest, text);
      },
      "SEED", "seed");
}

}  // namespace equilux
