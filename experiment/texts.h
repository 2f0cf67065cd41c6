// What a subject reads, by language: English is built in, another language is a file to add.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>

namespace equilux {

/// A table of texts by name. All languages have the same names.
class Texts {
 public:
  explicit Texts(std::map<std::string, std::string> texts) : texts_(std::move(texts)) {}

  bool has(const std::string& name) const { return texts_.contains(name); }
  const std::string& at(const std::string& name) const;
  /// The text with {name} replaced by each value.
  std::string fill(const std::string& name,
                   std::initializer_list<std::pair<const char*, std::string>> values) const;
  const std::map<std::string, std::string>& all() const { return texts_; }

 private:
  std::map<std::string, std::string> texts_;
};

/// Where a study folder keeps the texts of a language.
std::filesystem::path find_texts_file(const std::string& language, const std::filesystem::path& folder);

/// `folder`/texts-LANGUAGE.json where there is one, else the English that is built in. errors: InputError for
/// another language without a file, and for a file that lacks a name, has one too many, or other {places} in
/// a text.
Texts load_texts(const std::string& language, const std::filesystem::path& folder);

}  // namespace equilux
