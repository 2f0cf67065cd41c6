// The questions as subjects read them, in the languages of their sessions.
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "analysis/evidence.h"

namespace equilux {

/// Questions of an experiment by language. Several where pooled folders have different texts, none where the
/// texts of a language are not at hand.
using Prompts = std::map<std::string, std::set<std::string>>;

/// Sessions by the language that they recorded; "" for those that did not.
std::map<std::string, std::size_t> count_languages(const ExperimentEvidence& evidence);

/// What the finished sessions recorded; "" is the language of those that recorded none.
Prompts find_recorded_prompts(const ExperimentEvidence& evidence);

/// Of the languages of the finished sessions: what these recorded; of those that recorded no question also
/// `folder`/texts-LANGUAGE.json as it is now, else the English that is built in. errors: InputError for a
/// file that is no JSON
Prompts load_prompts(const std::filesystem::path& folder, const ExperimentEvidence& evidence,
                     Experiment experiment);

}  // namespace equilux
