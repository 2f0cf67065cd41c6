// JSON values, files and schemas; errors name file, JSON pointer, expected and got.
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace equilux {

/// A JSON value. Objects keep the order in which members were added.
class Json {
 public:
  using Array = std::vector<Json>;
  using Object = std::vector<std::pair<std::string, Json>>;

  Json() = default;
  Json(std::nullptr_t) {}
  Json(std::same_as<bool> auto value) : value_(value) {}
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json(T value) : value_(static_cast<std::int64_t>(value)) {}
  Json(double value) : value_(value) {}
  Json(std::string value) : value_(std::move(value)) {}
  Json(std::string_view value) : value_(std::string(value)) {}
  Json(const char* value) : value_(std::string(value)) {}
  Json(Array value) : value_(std::move(value)) {}
  Json(Object value) : value_(std::move(value)) {}

  bool is_null() const { return std::holds_alternative<std::monostate>(value_); }
  bool is_bool() const { return std::holds_alternative<bool>(value_); }
  bool is_integer() const { return std::holds_alternative<std::int64_t>(value_); }
  bool is_number() const { return is_integer() || std::holds_alternative<double>(value_); }
  bool is_string() const { return std::holds_alternative<std::string>(value_); }
  bool is_array() const { return std::holds_alternative<Array>(value_); }
  bool is_object() const { return std::holds_alternative<Object>(value_); }

  // Reading a value that a schema has vouched for; a wrong type is our own bug (CheckFailure).
  bool as_bool() const;
  std::int64_t as_int() const;
  double as_double() const;
  const std::string& as_string() const;
  const Array& as_array() const;
  const Object& as_object() const;
  std::vector<std::string> as_strings() const;

  /// The member, or nullptr where there is none (or this is no object).
  const Json* find(std::string_view key) const;
  const Json& at(std::string_view key) const;
  const Json& at(std::size_t index) const;

  /// Adds or replaces a member (makes an object of null). Returns *this for chaining.
  Json& set(std::string_view key, Json value);
  /// Adds an element (makes an array of null).
  Json& push(Json value);

  bool operator==(const Json&) const = default;

 private:
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object> value_;
};

/// Array of strings.
Json make_json(const std::vector<std::string>& values);

/// What a JSON file may take. The tree has some 40 bytes a value.
struct JsonLimits {
  std::size_t bytes = std::size_t{64} << 20;
  std::size_t values = 4'000'000;  ///< in all
};

/// errors: InputError naming `source`, line and column; duplicate keys, more than 64 levels, 256 members in
/// an object, more values than the limit, and strings of more than 4,096 bytes or with a zero byte are
/// refused.
Json parse_json(std::string_view text, std::string_view source, const JsonLimits& limits = {});

/// Indented text with a final newline; numbers keep their shortest exact form. A number that is not finite is
/// our bug.
std::string format_json(const Json& value);

/// Members sorted, no white space: equal values give equal text. What digests are taken of.
std::string format_canonical_json(const Json& value);

/// Digest of the canonical text.
std::string digest_json(const Json& value);

/// Checks against a JSON Schema (draft 7), the lengths of arrays first. errors: InputError with `source` and
/// the JSON pointer of the deepest failure.
void validate_json(const Json& value, std::string_view schema, std::string_view source);

/// Load, parse and validate.
Json load_json(const std::filesystem::path& path, std::string_view schema, const JsonLimits& limits = {});

/// "text", 3.5, an array of 4 elements: a value as an error message shows it.
std::string describe_json(const Json& value);

}  // namespace equilux
