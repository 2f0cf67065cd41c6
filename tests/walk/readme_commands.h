// The commands of a README: the lines of its blocks fenced as ```sh.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"

namespace equilux {

struct ReadmeCommand {
  int line = 0;
  std::string text;
  std::string reason;  ///< why it is not tested; empty: it is
};

inline const std::string kNotTested = "# not tested:";

inline std::string trim(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t") + 1 - begin);
}

inline ReadmeCommand parse_readme_command(const std::string& text, int line) {
  const auto mark = text.find("# not tested");
  if (mark == std::string::npos) return {line, trim(text), ""};
  const std::string words = text.substr(mark);
  const std::string reason = words.starts_with(kNotTested) ? trim(words.substr(kNotTested.size())) : "";
  if (reason.empty()) {
    throw InputError("README.md", fmt::format("line {}", line), kNotTested + " REASON", words);
  }
  return {line, trim(text.substr(0, mark)), reason};
}

/// In their order. errors: InputError for a mark without a reason.
inline std::vector<ReadmeCommand> parse_readme_commands(const std::string& markdown) {
  std::vector<ReadmeCommand> commands;
  std::istringstream stream(markdown);
  bool inside = false;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (line.starts_with("```")) {
      inside = line == "```sh";
    } else if (inside && !trim(line).empty()) {
      commands.push_back(parse_readme_command(line, number));
    }
  }
  return commands;
}

/// The names in backquotes in the first cells of the table under a heading; <kind> is planted.
inline std::vector<std::string> parse_readme_table_names(const std::string& markdown,
                                                         const std::string& heading) {
  const auto begin = markdown.find("## " + heading + "\n");
  if (begin == std::string::npos) throw InputError("README.md", "", "the heading " + heading, "none");
  std::istringstream section(markdown.substr(begin, markdown.find("\n## ", begin) - begin));
  std::vector<std::string> names;
  for (std::string line; std::getline(section, line);) {
    if (!line.starts_with("| `")) continue;
    std::istringstream words(line.substr(0, line.find(" | ", 2)));
    std::string word;
    while (std::getline(words, word, '`') && std::getline(words, word, '`')) {
      const auto kind = word.find("<kind>");
      names.push_back(kind == std::string::npos ? word : word.replace(kind, 6, "planted"));
    }
  }
  return names;
}

}  // namespace equilux
