// Options that several subcommands share.
#include "renderer/commands.h"

#include <fmt/format.h>

namespace equilux {

void add_threads(CLI::App& subcommand, CommandLine& line) {
  subcommand.add_option("--threads", line.threads, "Threads; 0 for all cores")->check(CLI::Range(0, 4096));
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
