// Tables of texts are read here for their prompts alone: whether one is complete is the session's concern.
#include "analysis/prompts.h"

#include <algorithm>
#include <cctype>

#include "base/files.h"
#include "base/json.h"

namespace equilux {
namespace {

constexpr const char* kBuiltIn = "en";

// What a log says is no path.
bool is_language(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '_';
  });
}

std::set<std::string> find_prompt(const std::filesystem::path& folder, const std::string& language,
                                  Experiment experiment) {
  if (!is_language(language)) return {};
  const std::filesystem::path path = folder / ("texts-" + language + ".json");
  if (!path_exists(path))
    return language == kBuiltIn ? std::set{prompt_of(experiment)} : std::set<std::string>{};
  const Json json = parse_json(load_text(path), path.string());
  const Json* texts = json.is_object() ? json.find("texts") : nullptr;
  const Json* prompt =
      texts && texts->is_object() ? texts->find("prompt_" + format_experiment(experiment)) : nullptr;
  return prompt && prompt->is_string() ? std::set{prompt->as_string()} : std::set<std::string>{};
}

}  // namespace

std::map<std::string, std::size_t> count_languages(const ExperimentEvidence& evidence) {
  std::map<std::string, std::size_t> languages;
  for (const SessionRow& row : evidence.finished) {
    const auto found = row.fields.find("language");
    ++languages[found == row.fields.end() ? "" : found->second];
  }
  return languages;
}

Prompts find_recorded_prompts(const ExperimentEvidence& evidence) {
  Prompts prompts;
  for (const SessionRow& row : evidence.finished) {
    const auto language = row.fields.find("language"), prompt = row.fields.find("prompt");
    if (prompt == row.fields.end()) continue;
    prompts[language == row.fields.end() ? "" : language->second].insert(prompt->second);
  }
  return prompts;
}

Prompts load_prompts(const std::filesystem::path& folder, const ExperimentEvidence& evidence,
                     Experiment experiment) {
  Prompts prompts;
  std::map<std::string, std::set<std::string>> of_folder;  // each language's texts are read once
  const auto find_once = [&](const std::string& language) -> const std::set<std::string>& {
    const auto found = of_folder.find(language);
    if (found != of_folder.end()) return found->second;
    return of_folder[language] = find_prompt(folder, language, experiment);
  };
  for (const SessionRow& row : evidence.finished) {
    const auto language = row.fields.find("language"), prompt = row.fields.find("prompt");
    if (language == row.fields.end()) continue;
    std::set<std::string>& of_language = prompts[language->second];
    if (prompt != row.fields.end()) {
      of_language.insert(prompt->second);
    } else {  // whatever others recorded: those may have read another one
      const auto& now = find_once(language->second);
      of_language.insert(now.begin(), now.end());
    }
  }
  prompts.erase("");
  return prompts;
}

}  // namespace equilux
