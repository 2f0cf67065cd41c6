// Numbers of things in the report's sentences.
#pragma once

#include <fmt/format.h>
#include <string>
#include <string_view>

namespace equilux {

/// "1 session", "2 sessions", of a thing whose plural ends in s.
template <typename Number>
std::string format_count(Number count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

/// "was" of one, "were" of several; and the like.
template <typename Number>
std::string_view choose_form(Number count, std::string_view of_one, std::string_view of_several) {
  return count == 1 ? of_one : of_several;
}

}  // namespace equilux
