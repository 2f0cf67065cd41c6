// Reading a table of texts, and holding it to the English one.
#include "experiment/texts.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"

namespace equilux {

extern const char kTextsEn[];

namespace {

constexpr const char* kBuiltIn = "en";
constexpr std::size_t kLongestText = 4000;

void check_schema(const Json& json, const std::string& source) {
  const Json *schema = json.find("schema"), *version = json.find("schema_version");
  if (!schema || *schema != Json("equilux-texts"))
    throw InputError(source, "/schema", "\"equilux-texts\"", schema ? describe_json(*schema) : "none");
  if (!version || *version != Json(1))
    throw InputError(source, "/schema_version", "1", version ? describe_json(*version) : "none");
}

std::map<std::string, std::string> read_texts(const Json& json, const std::string& source) {
  check_schema(json, source);
  const Json* table = json.find("texts");
  if (!table || !table->is_object()) throw InputError(source, "/texts", "an object of texts", "none");
  std::map<std::string, std::string> texts;
  for (const auto& [name, text] : table->as_object()) {
    if (!text.is_string() || text.as_string().empty() || text.as_string().size() > kLongestText)
      throw InputError(source, "/texts/" + name, fmt::format("a text of at most {} bytes", kLongestText),
                       describe_json(text));
    texts[name] = text.as_string();
  }
  return texts;
}

std::multiset<std::string> find_places(const std::string& text) {
  std::multiset<std::string> places;
  for (std::size_t open = text.find('{'); open != std::string::npos; open = text.find('{', open + 1)) {
    const std::size_t close = text.find('}', open);
    if (close != std::string::npos) places.insert(text.substr(open, close - open + 1));
  }
  return places;
}

void check_like_english(const std::map<std::string, std::string>& texts, const std::string& source) {
  const auto english = read_texts(parse_json(kTextsEn, kBuiltIn), kBuiltIn);
  for (const auto& [name, text] : english) {
    const auto found = texts.find(name);
    if (found == texts.end())
      throw InputError(source, "/texts/" + name, "a text for \"" + text + "\"", "none");
    if (find_places(found->second) != find_places(text))
      throw InputError(source, "/texts/" + name, "the same places in braces as in \"" + text + "\"",
                       found->second);
  }
  for (const auto& [name, text] : texts) {
    if (!english.contains(name))
      throw InputError(source, "/texts/" + name, "a name of the English table", "another");
  }
}

}  // namespace

const std::string& Texts::at(const std::string& name) const {
  const auto found = texts_.find(name);
  EQ_CHECK(found != texts_.end(), name);
  return found->second;
}

std::string Texts::fill(const std::string& name,
                        std::initializer_list<std::pair<const char*, std::string>> values) const {
  std::string text = at(name);
  for (const auto& [place, value] : values) {
    const std::string braces = fmt::format("{{{}}}", place);
    for (std::size_t at = text.find(braces); at != std::string::npos;
         at = text.find(braces, at + value.size()))
      text.replace(at, braces.size(), value);
  }
  return text;
}

std::filesystem::path find_texts_file(const std::string& language, const std::filesystem::path& folder) {
  return folder / ("texts-" + language + ".json");
}

Texts load_texts(const std::string& language, const std::filesystem::path& folder) {
  const std::filesystem::path path = find_texts_file(language, folder);
  if (!path_exists(path)) {
    if (language != kBuiltIn)
      throw InputError(path.string(), "", fmt::format("the texts of the protocol's language, {}", language),
                       "nothing of that name");
    return Texts(read_texts(parse_json(kTextsEn, kBuiltIn), kBuiltIn));
  }
  const auto texts = read_texts(parse_json(load_text(path), path.string()), path.string());
  check_like_english(texts, path.string());
  return Texts(texts);
}

}  // namespace equilux
