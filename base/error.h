// What goes wrong, and in whose hands: input from outside, the store, or our own bug.
#pragma once

#include <fmt/format.h>
#include <stdexcept>
#include <string>
#include <string_view>

namespace equilux {

/// Input from outside that cannot be used; the message names file, place, expected and got.
class InputError : public std::runtime_error {
 public:
  explicit InputError(const std::string& message) : std::runtime_error(message) {}

  /// `place` is a JSON pointer, a line, an option; empty when the whole file is meant.
  InputError(std::string_view path, std::string_view place, std::string_view expected, std::string_view got)
      : std::runtime_error(place.empty()
                               ? fmt::format("{}: expected {}, got {}", path, expected, got)
                               : fmt::format("{}: {}: expected {}, got {}", path, place, expected, got)) {}
};

/// Something recorded could not be written or read back; whoever meets it must stop, never go on unrecorded.
class StoreError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A violated EQ_CHECK: our own bug, never the user's.
class CheckFailure : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

[[noreturn]] void fail_check(const char* file, int line, const char* text, const std::string& values);

}  // namespace equilux

/// An invariant of ours, on in every build. EQ_CHECK(a < b, a, b) prints the values after the condition.
#define EQ_CHECK(condition, ...)                                                                    \
  do {                                                                                              \
    if (!(condition)) [[unlikely]]                                                                  \
      ::equilux::fail_check(__FILE__, __LINE__, #condition, ::equilux::format_values(__VA_ARGS__)); \
  } while (false)

namespace equilux {
inline std::string format_values() { return {}; }
template <typename First, typename... Rest>
std::string format_values(const First& first, const Rest&... rest) {
  std::string text = fmt::format("{}", first);
  ((text += fmt::format(", {}", rest)), ...);
  return text;
}
}  // namespace equilux
