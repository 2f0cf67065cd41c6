// JSON text to values and back: what is refused and where, and that nothing is lost.
#include "base/json.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "base/digest.h"
#include "base/error.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

std::string refusal_of(const std::string& text) {
  return message_of<InputError>([&] { parse_json(text, "a.json"); });
}

TEST(ParseJson, SaysLineAndColumnOfAnError) {
  EXPECT_THAT(refusal_of("{\"a\": 1,\n  \"b\" 2}"),
              StartsWith("a.json: line 2, column 7: expected valid JSON"));
  EXPECT_THAT(refusal_of("}"), StartsWith("a.json: line 1, column 1: "));
  EXPECT_THAT(refusal_of("[1,\n2,\n3}"), StartsWith("a.json: line 3, column 2: "));
  EXPECT_THAT(refusal_of("[1]\n x"), StartsWith("a.json: line 2, column 2: "));
}

TEST(ParseJson, RefusesWhatIsNotJson) {
  for (const char* text :
       {"",        " ",       "{",        "[",         "[1,]",          "{\"a\":1,}", "{'a':1}", "[01]",
        "[1.]",    "[.5]",    "[+1]",     "[NaN]",     "[Infinity]",    "nul",        "\"open",  "[1] [2]",
        "{\"a\"}", "// c\n1", "[\"\t\"]", "[\"\\x\"]", "[\"\\ud800\"]", "[1e]",       "\xef\xbb"}) {
    EXPECT_THAT(refusal_of(text), StartsWith("a.json: line ")) << text;
  }
}

TEST(ParseJson, RefusesInvalidUtf8) {
  for (const char* text : {"[\"\xff\"]", "[\"\xc3\"]", "[\"\xc0\xaf\"]", "[\"\xed\xa0\x80\"]",
                           "[\"\xf5\x80\x80\x80\"]", "{\"\xfe\": 1}"}) {
    EXPECT_THAT(refusal_of(text), HasSubstr("expected valid JSON"));
  }
  EXPECT_EQ(parse_json("[\"K\xc5\x99iv\xc3\xa1nek\"]", "a").at(0).as_string(), "K\xc5\x99iv\xc3\xa1nek");
}

TEST(ParseJson, RefusesADuplicateKeyAndPointsAtIt) {
  EXPECT_THAT(refusal_of(R"({"a": 1, "a": 1})"), StartsWith("a.json: /a: expected each member name once"));
  EXPECT_THAT(refusal_of(R"({"x": [0, {"b/c": 1, "m~n": 2, "b/c": 3}]})"), StartsWith("a.json: /x/1/b~1c: "));
  EXPECT_THAT(refusal_of(R"({"x": {"m~n": {}, "m~n": 2}})"), StartsWith("a.json: /x/m~0n: "));
  EXPECT_NO_THROW(parse_json(R"([{"a": 1}, {"a": {"a": 2}}])", "a.json"));
}

TEST(ParseJson, BoundsItsDepth) {
  const auto nested = [](int depth) { return std::string(depth, '[') + std::string(depth, ']'); };
  EXPECT_NO_THROW(parse_json(nested(64), "a.json"));
  EXPECT_THAT(refusal_of(nested(65)), HasSubstr("at most 64 levels"));
  EXPECT_THAT(refusal_of(std::string(1000000, '[')), HasSubstr("at most 64 levels"));
}

TEST(ParseJson, BoundsItsStringsAndNames) {
  const auto quoted = [](int length) { return "\"" + std::string(length, 'x') + "\""; };
  EXPECT_NO_THROW(parse_json(quoted(4096), "a.json"));
  EXPECT_THAT(refusal_of("{\"a\": [" + quoted(4097) + "]}"),
              AllOf(StartsWith("a.json: /a/0: "), HasSubstr("at most 4096 bytes"), HasSubstr("4097")));
  EXPECT_THAT(refusal_of("{" + quoted(5000) + ": 1}"), HasSubstr("at most 4096 bytes"));
}

TEST(ParseJson, RefusesAZeroByteInAString) {
  EXPECT_EQ(refusal_of(R"({"a": ["b\u0000c"]})"),
            "a.json: /a/0: expected strings without zero bytes, got one");
  EXPECT_EQ(refusal_of(R"({"a\u0000b": 1})"), "a.json: /a: expected strings without zero bytes, got one");
}

TEST(ParseJson, BoundsItsMembersAndValues) {
  const auto object_of = [](int members) {
    std::string text = "{";
    for (int i = 0; i < members; ++i) text += fmt::format("{}\"m{}\": 0", i ? ", " : "", i);
    return text + "}";
  };
  EXPECT_EQ(parse_json(object_of(256), "a.json").as_object().size(), 256u);
  EXPECT_THAT(refusal_of("{\"a\": " + object_of(257) + "}"),
              AllOf(StartsWith("a.json: /a/"), HasSubstr("at most 256 members in an object, got more")));
  std::string zeros = "[0";
  for (int i = 1; i < 4'000'000; ++i) zeros += ",0";
  EXPECT_THAT(refusal_of(zeros + "]"), HasSubstr("at most 4000000 values in all, got more"));
  EXPECT_NO_THROW(parse_json("[0,0,0]", "a.json", {.values = 4}));
  EXPECT_THAT(message_of<InputError>([] { parse_json("[0,0,0]", "a.json", {.values = 3}); }),
              HasSubstr("at most 3 values in all, got more"));
}

TEST(ParseJson, RefusesANumberBeyondDouble) {
  EXPECT_THAT(refusal_of("[1e400]"), HasSubstr("a.json: "));
  EXPECT_EQ(parse_json("[1e-400]", "a").at(0).as_double(), 0);
}

TEST(JsonNumbers, RoundTripExactly) {
  for (double value :
       {0.1, 1.0 / 3, 1e-300, 1.7976931348623157e308, 5e-324, -2.5, 3.0, 1e19, 123456789.123456789}) {
    const Json back = parse_json(format_json(Json(value)), "a");
    EXPECT_EQ(back.as_double(), value);
    EXPECT_FALSE(back.is_integer()) << value;
  }
  const auto most = std::numeric_limits<std::int64_t>::max(),
             least = std::numeric_limits<std::int64_t>::min();
  for (std::int64_t value : {std::int64_t{0}, std::int64_t{-1}, most, least, (std::int64_t{1} << 53) + 1}) {
    const Json back = parse_json(format_json(Json(value)), "a");
    EXPECT_TRUE(back.is_integer());
    EXPECT_EQ(back.as_int(), value);
  }
}

TEST(JsonNumbers, ThatAreNotFiniteAreOurBug) {
  EXPECT_THROW(format_json(Json(std::nan(""))), CheckFailure);
  EXPECT_THROW(format_json(Json(std::numeric_limits<double>::infinity())), CheckFailure);
}

TEST(JsonValues, RoundTripThroughTextAndKeepTheirOrder) {
  const std::string text = R"({"z": [1, 2.5, "t\"\\\n\u0001", null, true, {}, []], "a": {"b": false}})";
  const Json value = parse_json(text, "a");
  EXPECT_EQ(parse_json(format_json(value), "b"), value);
  EXPECT_EQ(value.as_object().front().first, "z");
  EXPECT_EQ(format_json(value).back(), '\n');
}

// What digests of older studies were taken of, and what files hold: by nlohmann-json.
TEST(JsonValues, AreWrittenWithTheBytesTheyAlwaysHad) {
  const Json value = parse_json(
      R"({"z": [1, -2.5, [], {}, [[3]]], "a\tb": "q\"\\\u0001\u007f/", "\u00e9": {"y": 1e-7, "x": 1e20}, "n": 3.0})",
      "a");
  EXPECT_EQ(format_json(value), R"({
  "z": [
    1,
    -2.5,
    [],
    {},
    [
      [
        3
      ]
    ]
  ],
  "a\tb": "q\"\\\u0001/",
  "é": {
    "y": 1e-07,
    "x": 1e+20
  },
  "n": 3.0
}
)");
  EXPECT_EQ(format_canonical_json(value),
            "{\"a\\tb\":\"q\\\"\\\\\\u0001\x7f/\",\"n\":3.0,\"z\":[1,-2.5,[],{},[[3]]],"
            "\"\xc3\xa9\":{\"x\":1e+20,\"y\":1e-07}}");
  EXPECT_EQ(format_canonical_json(Json(std::string("\xff"))), "\"\xef\xbf\xbd\"");
  EXPECT_EQ(format_json(Json(Json::Array{})) + format_json(Json(Json::Object{})) + format_json(Json()),
            "[]\n{}\nnull\n");
}

TEST(JsonValues, ReadAsAnotherTypeAreOurBug) {
  const Json value = parse_json(R"({"a": "x", "b": 1.5})", "a");
  EXPECT_THROW(value.at("a").as_int(), CheckFailure);
  EXPECT_THROW(value.at("b").as_int(), CheckFailure);
  EXPECT_THROW(value.at("a").as_bool(), CheckFailure);
  EXPECT_THROW(value.at("b").as_string(), CheckFailure);
  EXPECT_THROW(value.at("c"), CheckFailure);
  EXPECT_THROW(value.as_array(), CheckFailure);
  EXPECT_EQ(value.find("c"), nullptr);
}

TEST(JsonValues, AreSetAndReplacedByName) {
  Json value;
  value.set("a", 1).set("b", "x").set("a", 2);
  EXPECT_EQ(format_canonical_json(value), R"({"a":2,"b":"x"})");
  EXPECT_EQ(make_json({"x", "y"}).as_strings(), (std::vector<std::string>{"x", "y"}));
}

TEST(CanonicalJson, IsSortedWithoutWhiteSpaceAndBlindToOrder) {
  const Json one = parse_json(R"({"b": {"y": 1, "x": [3, 1]}, "a": 0.1})", "a");
  const Json other = parse_json(R"({"a": 1e-1, "b": {"x": [3, 1], "y": 1}})", "a");
  EXPECT_EQ(format_canonical_json(one), R"({"a":0.1,"b":{"x":[3,1],"y":1}})");
  EXPECT_EQ(digest_json(one), digest_json(other));
  EXPECT_EQ(digest_json(one), digest_text(format_canonical_json(one)));
  const Json swapped = parse_json(R"({"b": {"y": 1, "x": [1, 3]}, "a": 0.1})", "a");
  EXPECT_NE(digest_json(one), digest_json(swapped)) << "the order of an array counts";
}

TEST(DescribeJson, IsShortEnoughForAMessage) {
  EXPECT_EQ(describe_json(Json("text")), "\"text\"");
  EXPECT_EQ(describe_json(Json(3.5)), "3.5");
  EXPECT_EQ(describe_json(Json()), "null");
  EXPECT_EQ(describe_json(parse_json("[1,2,3,4]", "a")), "an array of 4 elements");
  EXPECT_EQ(describe_json(parse_json("{\"a\":1}", "a")), "an object of 1 members");
  EXPECT_LT(describe_json(Json(std::string(4000, 'x'))).size(), 80u);
  EXPECT_EQ(describe_json(Json(std::string(61, 'x'))), "\"" + std::string(60, 'x') + "...\"");
  EXPECT_EQ(describe_json(Json(std::string(4000, '\x1b'))).find('\x1b'), std::string::npos);
}

TEST(LoadJson, NamesTheFileForEveryKindOfFailure) {
  const TempFolder folder;
  const char* schema = R"({"type": "object", "required": ["a"]})";
  EXPECT_EQ(load_json(folder.write("good", "{\"a\": 1}"), schema).at("a").as_int(), 1);
  for (const auto& [name, text] :
       {std::pair{"broken", "{"}, {"other", "[]"}, {"lacking", "{}"}, {"empty", ""}}) {
    const auto path = folder.write(name, text);
    EXPECT_THAT(message_of<InputError>([&] { load_json(path, schema); }), StartsWith(path.string() + ": "));
  }
  EXPECT_THROW(load_json(folder / "missing", schema), InputError);
  EXPECT_THROW(load_json(folder.path(), schema), InputError);
}

}  // namespace
}  // namespace equilux
