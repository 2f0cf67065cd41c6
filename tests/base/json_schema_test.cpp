// Values against schemas: the message has the JSON pointer of the place, what was expected, and what stood
// there.
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/json.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kSchema = R"({
  "type": "object", "additionalProperties": false, "required": ["name"],
  "properties": {
    "name": {"type": "string", "maxLength": 8, "pattern": "^[a-z]+$"},
    "kind": {"enum": ["cat", "dog"]},
    "version": {"const": 1},
    "count": {"type": "integer", "minimum": 1, "maximum": 9},
    "share": {"type": "number", "exclusiveMinimum": 0},
    "a/b": {"type": "object", "properties": {"m~n": {"type": "array", "items": {"type": "boolean"}}}},
    "point": {"$ref": "#/definitions/point"},
    "line": {"type": "array", "minItems": 1, "maxItems": 3, "items": {"$ref": "#/definitions/point"}},
    "set": {"type": "array", "uniqueItems": true}
  },
  "definitions": {
    "number": {"type": "number", "maximum": 100},
    "point": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"$ref": "#/definitions/number"}}
  }
})";

std::string refusal_of(const std::string& text) {
  return message_of<InputError>([&] { validate_json(parse_json(text, "a.json"), kSchema, "a.json"); });
}

TEST(ValidateJson, TakesWhatTheSchemaAllows) {
  EXPECT_NO_THROW(
      validate_json(parse_json(R"({"name": "abc", "kind": "dog", "version": 1, "count": 9, "share": 0.1,
    "a/b": {"m~n": [true]}, "point": [1, 2.5], "line": [[1, 2], [3, 100]], "set": [1, 2]})",
                               "a.json"),
                    kSchema, "a.json"));
}

TEST(ValidateJson, NamesAMissingMember) {
  EXPECT_EQ(refusal_of("{}"), "a.json: /: expected a member \"name\", got none");
}

TEST(ValidateJson, NamesAnAdditionalMember) {
  EXPECT_THAT(
      refusal_of(R"({"name": "abc", "nmae": 1})"),
      AllOf(StartsWith("a.json: /"), HasSubstr("only the members name, kind"), HasSubstr("\"nmae\"")));
}

// All pairs of 30,000 equal elements would fail, each with a line of its own.
TEST(ValidateJson, CountsElementsBeforeItComparesThem) {
  constexpr const char* kUnique = R"({
    "type": "object", "properties": {"set": {"type": "array", "maxItems": 4, "uniqueItems": true}}
  })";
  std::string ones = "1";
  for (int i = 1; i < 30000; ++i) ones += ",1";
  EXPECT_EQ(
      message_of<InputError>(
          [&] { validate_json(parse_json("{\"set\": [" + ones + "]}", "a.json"), kUnique, "a.json"); }),
      "a.json: /set: expected array with element count at most 4 without repetition, got an array of 30000 "
      "elements");
}

TEST(ValidateJson, PointsAtTheDeepestFailure) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"name": 7})", "a.json: /name: expected string"},
      {R"({"name": "ABC"})", "a.json: /name: expected string"},
      {R"({"name": "abcdefghi"})", "a.json: /name: expected string of length"},
      {R"({"name": "a", "kind": "cow"})", "a.json: /kind: expected one of cat, dog, got \"cow\""},
      {R"({"name": "a", "version": 2})", "a.json: /version: expected 1, got 2"},
      {R"({"name": "a", "count": 0})", "a.json: /count: expected integer of at least 1"},
      {R"({"name": "a", "count": 1.5})", "a.json: /count: expected integer"},
      {R"({"name": "a", "count": "1"})", "a.json: /count: expected integer"},
      {R"({"name": "a", "share": 0})", "a.json: /share: expected number over 0"},
      {R"({"name": "a", "point": [1]})", "a.json: /point: expected array with element count at least 2"},
      {R"({"name": "a", "point": [1, 2, 3]})", "a.json: /point: expected array"},
      {R"({"name": "a", "point": [1, 101]})", "a.json: /point/1: expected number of at most 100, got 101"},
      {R"({"name": "a", "line": [[1, 2], [3, null]]})", "a.json: /line/1/1: expected number"},
      {R"({"name": "a", "line": []})", "a.json: /line: expected array"},
      {R"({"name": "a", "set": [1, 1]})", "a.json: /set: expected array without repetition"},
      {R"({"name": "a", "a/b": {"m~n": [true, 1]}})", "a.json: /a~1b/m~0n/1: expected boolean, got 1"},
      {"[]", "a.json: /: expected object"}};
  for (const auto& [text, message] : cases) EXPECT_THAT(refusal_of(text), StartsWith(message)) << text;
}

// A pattern that could stop at a line's end would let a path in by its second line.
TEST(ValidateJson, MatchesPatternsAgainstTheWholeString) {
  for (const char* text :
       {R"({"name": "a\n"})", R"({"name": "\na"})", R"({"name": "a\nb"})", R"({"name": "a\u0000"})"})
    EXPECT_THAT(refusal_of(text), StartsWith("a.json: /name: ")) << text;
}

TEST(ValidateJson, RefusesAnIntegerThatOnlyADoubleHolds) {
  const char* schema = R"({"type": "object", "properties": {"seed": {"type": "integer", "minimum": 0}}})";
  for (const char* text :
       {R"({"seed": 1e19})", R"({"seed": 18446744073709551615})", R"({"seed": 9223372036854775808})"}) {
    EXPECT_THAT(message_of<InputError>([&] { validate_json(parse_json(text, "a"), schema, "a"); }),
                StartsWith("a: /seed: "))
        << text;
  }
}

}  // namespace
}  // namespace equilux
