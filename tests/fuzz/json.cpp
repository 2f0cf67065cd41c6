// Any text as JSON, and against a schema that has every keyword which ours use.
#include "base/json.h"

#include "tests/fuzz/fuzz.h"

namespace {

constexpr const char* kSchema = R"({
  "type": "object", "additionalProperties": false, "required": ["a"],
  "properties": {
    "a": { "type": "array", "minItems": 1, "maxItems": 8, "uniqueItems": true, "items": { "$ref": "#/definitions/row" } },
    "b": { "enum": ["x", 1, null] }, "c": { "const": 2 },
    "d": { "type": "string", "minLength": 1, "maxLength": 8, "pattern": "^[A-Za-z][A-Za-z0-9]*$" },
    "e": { "type": "object", "additionalProperties": { "type": "number" } }
  },
  "definitions": {
    "row": { "type": ["object", "number"], "minimum": -1, "exclusiveMaximum": 9,
             "properties": { "n": { "type": "integer", "exclusiveMinimum": 0, "maximum": 5 } } }
  }
})";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  const std::string_view text = as_text(bytes, size);
  expect_read_or_refused("input.json", [&] {
    const Json value = parse_json(text, "input.json");
    EQ_CHECK(parse_json(format_json(value), "formatted") == value);
    EQ_CHECK(digest_json(parse_json(format_canonical_json(value), "canonical")) == digest_json(value));
    validate_json(value, kSchema, "input.json");
  });
  return 0;
}
