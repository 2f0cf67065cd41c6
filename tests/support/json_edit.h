// Copies of JSON values that differ in one place, named by a JSON pointer without escapes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "base/json.h"

namespace equilux {

/// The value with the place set to `replacement`, or taken away. A place that is not there yet is added; "-"
/// is the end of an array.
inline Json with_place(const Json& value, std::string_view pointer, const std::optional<Json>& replacement) {
  if (pointer.empty()) return replacement.value_or(Json());
  const std::size_t end = std::min(pointer.find('/', 1), pointer.size());
  const std::string token(pointer.substr(1, end - 1));
  const std::string_view rest = pointer.substr(end);
  const bool drops = rest.empty() && !replacement;
  if (value.is_array()) {
    Json::Array elements = value.as_array();
    const std::size_t index = token == "-" ? elements.size() : std::stoul(token);
    if (index == elements.size()) elements.emplace_back();
    if (drops) {
      elements.erase(elements.begin() + static_cast<std::ptrdiff_t>(index));
    } else {
      elements.at(index) = with_place(elements[index], rest, replacement);
    }
    return Json(std::move(elements));
  }
  Json object{Json::Object{}};
  for (const auto& [key, member] : value.as_object()) {
    if (key != token) object.set(key, member);
    if (key == token && !drops) object.set(key, with_place(member, rest, replacement));
  }
  if (!drops && !value.find(token)) object.set(token, with_place(Json(), rest, replacement));
  return object;
}

inline Json with(const Json& value, std::string_view pointer, Json replacement) {
  return with_place(value, pointer, std::move(replacement));
}

inline Json without(const Json& value, std::string_view pointer) {
  return with_place(value, pointer, std::nullopt);
}

/// Every object's members in reverse order: another text of the same value.
inline Json reversed(const Json& value) {
  if (value.is_array()) {
    Json::Array elements;
    for (const Json& element : value.as_array()) elements.push_back(reversed(element));
    return Json(std::move(elements));
  }
  if (!value.is_object()) return value;
  Json::Object members;
  const auto& old = value.as_object();
  for (auto member = old.rbegin(); member != old.rend(); ++member)
    members.emplace_back(member->first, reversed(member->second));
  return Json(std::move(members));
}

}  // namespace equilux
