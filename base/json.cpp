// The one file that knows nlohmann-json and valijson.
#include "base/json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxStringBytes = 4096;
constexpr std::size_t kMaxMembers =
    256;  // twelve times what any of our objects has; they are searched in line

// The std::regex of schemas fills a table of the locale as it goes, without a lock (GCC bug 77704): it is
// filled before threads can meet there.
void prepare_regex() {
  [[maybe_unused]] static const char last = [] {
    std::array<char, 256> all{}, narrowed{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<char>(i);
    const auto& characters = std::use_facet<std::ctype<char>>(std::locale());
    characters.narrow(all.data(), all.data() + all.size(), '\0', narrowed.data());
    for (const char character : all) characters.narrow(character, '\0');
    return narrowed.back();
  }();
}

std::string escape_pointer(std::string_view token) {
  std::string escaped;
  for (char character : token) {
    if (character == '~') {
      escaped += "~0";
    } else if (character == '/') {
      escaped += "~1";
    } else {
      escaped += character;
    }
  }
  return escaped;
}

// Builds the tree from parse events, because nlohmann's own tree keeps only the last of duplicate keys.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
 public:
  TreeBuilder(std::string_view text, std::string_view source, std::size_t max_values)
      : text_(text), source_(source), max_values_(max_values) {}

  Json take() { return std::move(root_); }

  bool null() override { return add(Json()); }
  bool boolean(bool value) override { return add(Json(value)); }
  bool number_integer(number_integer_t value) override { return add(Json(value)); }
  bool number_unsigned(number_unsigned_t value) override {
    if (value > static_cast<number_unsigned_t>(std::numeric_limits<std::int64_t>::max())) {
      return add(Json(static_cast<double>(value)));
    }
    return add(Json(value));
  }
  bool number_float(number_float_t value, const string_t& text) override {
    if (!std::isfinite(value)) throw InputError(source_, pointer(), "a number within double's range", text);
    return add(Json(value));
  }
  bool string(string_t& value) override {
    check_string(value);
    return add(Json(std::move(value)));
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(std::size_t) override { return open(Json(Json::Object{})); }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(Json(Json::Array{})); }
  bool end_array() override { return close(); }
  bool key(string_t& name) override {
    open_.back().key = name.size() > kMaxStringBytes ? name.substr(0, 60) : std::string(name.c_str());
    check_string(name);
    if (open_.back().keys.size() == kMaxMembers) {
      throw InputError(source_, pointer(), fmt::format("at most {} members in an object", kMaxMembers),
                       "more");
    }
    if (!open_.back().keys.insert(name).second) {
      throw InputError(source_, pointer(), "each member name once in an object", "a second one");
    }
    return true;
  }
  bool parse_error(std::size_t position, const std::string& token,
                   const nlohmann::json::exception&) override {
    const std::size_t end = std::min(position > 0 ? position - 1 : 0, text_.size());
    const std::string_view before = text_.substr(0, end);
    const auto line = 1 + std::count(before.begin(), before.end(), '\n');
    const std::size_t column =
        end - (before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1) + 1;
    throw InputError(source_, fmt::format("line {}, column {}", line, column), "valid JSON",
                     token.empty() ? "the end of the text" : fmt::format("'{}'", token.substr(0, 40)));
  }

 private:
  struct Level {
    Json value;
    std::string key;
    std::set<std::string> keys;
  };

  std::string pointer() const {
    std::string text;
    for (const Level& level : open_) {
      text += level.value.is_array() ? fmt::format("/{}", level.value.as_array().size())
                                     : "/" + escape_pointer(level.key);
    }
    return text;
  }
  void check_string(const std::string& value) const {
    if (value.size() > kMaxStringBytes) {
      throw InputError(source_, pointer(), fmt::format("strings of at most {} bytes", kMaxStringBytes),
                       fmt::format("{} bytes", value.size()));
    }
    // A file's name would end there for the system, and a message on the screen.
    if (value.find('\0') != std::string::npos)
      throw InputError(source_, pointer(), "strings without zero bytes", "one");
  }
  bool add(Json value) {
    if (++values_ > max_values_)
      throw InputError(source_, pointer(), fmt::format("at most {} values in all", max_values_), "more");
    if (open_.empty()) {
      root_ = std::move(value);
    } else if (open_.back().value.is_array()) {
      open_.back().value.push(std::move(value));
    } else {
      members_of_back().emplace_back(open_.back().key, std::move(value));
    }
    return true;
  }
  Json::Object& members_of_back() { return const_cast<Json::Object&>(open_.back().value.as_object()); }
  bool open(Json value) {
    if (open_.size() >= kMaxDepth) {
      throw InputError(source_, "", fmt::format("at most {} levels of nesting", kMaxDepth), "more");
    }
    open_.push_back({std::move(value), {}, {}});
    return true;
  }
  bool close() {
    Json value = std::move(open_.back().value);
    open_.pop_back();
    return add(std::move(value));
  }

  std::string_view text_;
  std::string source_;
  std::vector<Level> open_;
  std::size_t max_values_, values_ = 0;
  Json root_;
};

nlohmann::ordered_json to_nlohmann(const Json& value) {
  if (value.is_null()) return nullptr;
  if (value.is_bool()) return value.as_bool();
  if (value.is_integer()) return value.as_int();
  if (value.is_number()) {
    EQ_CHECK(std::isfinite(value.as_double()), value.as_double());
    return value.as_double();
  }
  if (value.is_string()) return value.as_string();
  if (value.is_array()) {
    auto array = nlohmann::ordered_json::array();
    for (const Json& element : value.as_array()) array.push_back(to_nlohmann(element));
    return array;
  }
  auto object = nlohmann::ordered_json::object();
  for (const auto& [key, member] : value.as_object()) object.emplace(key, to_nlohmann(member));
  return object;
}

std::string dump(const Json& value, int indent) {
  return to_nlohmann(value).dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

// valijson writes a place as <root>, ["name"], [0].
std::vector<std::string> pointer_tokens(const std::vector<std::string>& context) {
  std::vector<std::string> tokens;
  for (const std::string& part : context) {
    if (part.empty() || part.front() != '[') continue;
    const bool quoted = part.size() >= 4 && part[1] == '"';
    tokens.push_back(quoted ? part.substr(2, part.size() - 4) : part.substr(1, part.size() - 2));
  }
  return tokens;
}

const Json* follow(const Json& value, const std::string& token) {
  if (value.is_object()) return value.find(token);
  if (!value.is_array() || token.empty() || token.find_first_not_of("0123456789") != std::string::npos)
    return nullptr;
  const std::size_t index = std::stoull(token);
  return index < value.as_array().size() ? &value.as_array()[index] : nullptr;
}

const Json& resolve(const Json& root, const Json& schema) {
  const Json* reference = schema.find("$ref");
  if (!reference) return schema;
  const std::string& target = reference->as_string();
  const Json* node = &root;
  for (std::size_t start = 2; start <= target.size() && node;) {
    const std::size_t end = std::min(target.find('/', start), target.size());
    node = node->find(target.substr(start, end - start));
    start = end + 1;
  }
  EQ_CHECK(node != nullptr, target);
  return resolve(root, *node);
}

// The part of a schema that speaks of a place; null where it leaves the plain keywords.
const Json* schema_at(const Json& root, const std::vector<std::string>& tokens) {
  const Json* schema = &resolve(root, root);
  for (const std::string& token : tokens) {
    const Json* next = schema->find("properties");
    next = next ? next->find(token) : nullptr;
    if (!next) next = schema->find("items");
    if (!next) next = schema->find("additionalProperties");
    if (!next || !next->is_object()) return nullptr;
    schema = &resolve(root, *next);
  }
  return schema;
}

std::string list_of(const Json& values) {
  std::string text;
  for (const Json& value : values.as_array()) {
    text += (text.empty() ? "" : ", ") + (value.is_string() ? value.as_string() : describe_json(value));
  }
  return text;
}

struct Mismatch {
  std::string expected;
  std::string got;
};

std::optional<Mismatch> find_member_mismatch(const Json& schema, const Json& value) {
  if (const Json* required = schema.find("required")) {
    for (const Json& name : required->as_array()) {
      if (!value.find(name.as_string()))
        return Mismatch{fmt::format("a member \"{}\"", name.as_string()), "none"};
    }
  }
  const Json* additional = schema.find("additionalProperties");
  const Json* properties = schema.find("properties");
  if (additional && additional->is_bool() && !additional->as_bool() && properties) {
    for (const auto& [name, member] : value.as_object()) {
      if (properties->find(name)) continue;
      Json known{Json::Array{}};
      for (const auto& [known_name, unused] : properties->as_object()) known.push(known_name);
      return Mismatch{fmt::format("only the members {}", list_of(known)), fmt::format("\"{}\"", name)};
    }
  }
  return std::nullopt;
}

// The schema's words for what may stand there.
std::string describe_schema(const Json& schema) {
  if (const Json* description = schema.find("expected")) return description->as_string();
  if (const Json* values = schema.find("enum")) return "one of " + list_of(*values);
  if (const Json* value = schema.find("const")) return describe_json(*value);
  std::string text;
  if (const Json* type = schema.find("type")) text = type->is_string() ? type->as_string() : list_of(*type);
  const auto append = [&](const char* keyword, const char* words) {
    if (const Json* bound = schema.find(keyword)) text += fmt::format(" {} {}", words, describe_json(*bound));
  };
  append("minimum", "of at least");
  append("exclusiveMinimum", "over");
  append("maximum", "of at most");
  append("exclusiveMaximum", "under");
  append("minItems", "with element count at least");
  append("maxItems", "with element count at most");
  append("minLength", "of length at least");
  append("maxLength", "of length at most");
  append("pattern", "of the form");
  if (const Json* unique = schema.find("uniqueItems"); unique && unique->as_bool())
    text += " without repetition";
  return text.empty() ? "what the schema allows" : text;
}

[[noreturn]] void fail_validation(const Json& value, const Json& schema,
                                  const std::vector<std::string>& tokens, const std::string& description,
                                  std::string_view source) {
  std::string pointer;
  const Json* place = &value;
  for (const std::string& token : tokens) {
    pointer += "/" + escape_pointer(token);
    place = place ? follow(*place, token) : nullptr;
  }
  if (pointer.empty()) pointer = "/";
  const Json* wanted = schema_at(schema, tokens);
  if (!wanted || !place) throw InputError(source, pointer, "what the schema allows", description);
  if (place->is_object()) {
    if (const auto mismatch = find_member_mismatch(*wanted, *place)) {
      throw InputError(source, pointer, mismatch->expected, mismatch->got);
    }
  }
  throw InputError(source, pointer, describe_schema(*wanted), describe_json(*place));
}

// valijson compares all elements of an array with one another and keeps a line for each that fails, before it
// counts them.
void check_array_sizes(const Json& value, const Json& schema_part, const Json& schema,
                       const std::string& place, std::string_view source) {
  const Json& wanted = resolve(schema, schema_part);
  if (value.is_array()) {
    const Json* most = wanted.find("maxItems");
    if (most && value.as_array().size() > static_cast<std::size_t>(most->as_int()))
      throw InputError(source, place, describe_schema(wanted), describe_json(value));
    const Json* items = wanted.find("items");
    for (std::size_t i = 0; items && i < value.as_array().size(); ++i) {
      if (value.at(i).is_array() || value.at(i).is_object())
        check_array_sizes(value.at(i), *items, schema, fmt::format("{}/{}", place, i), source);
    }
  }
  const Json* properties = value.is_object() ? wanted.find("properties") : nullptr;
  if (!properties) return;
  for (const auto& [name, member] : value.as_object()) {
    if (const Json* part = properties->find(name))
      check_array_sizes(member, *part, schema, place + "/" + escape_pointer(name), source);
  }
}

Json sort_members(const Json& value) {
  if (value.is_array()) {
    Json::Array sorted;
    for (const Json& element : value.as_array()) sorted.push_back(sort_members(element));
    return Json(std::move(sorted));
  }
  if (!value.is_object()) return value;
  Json::Object members;
  for (const auto& [key, member] : value.as_object()) members.emplace_back(key, sort_members(member));
  std::sort(members.begin(), members.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return Json(std::move(members));
}

}  // namespace

bool Json::as_bool() const {
  EQ_CHECK(is_bool(), value_.index());
  return std::get<bool>(value_);
}

std::int64_t Json::as_int() const {
  if (const double* number = std::get_if<double>(&value_)) {
    EQ_CHECK(std::floor(*number) == *number && std::abs(*number) < 0x1p53, *number);
    return static_cast<std::int64_t>(*number);
  }
  EQ_CHECK(is_integer(), value_.index());
  return std::get<std::int64_t>(value_);
}

double Json::as_double() const {
  if (is_integer()) return static_cast<double>(std::get<std::int64_t>(value_));
  EQ_CHECK(is_number(), value_.index());
  return std::get<double>(value_);
}

const std::string& Json::as_string() const {
  EQ_CHECK(is_string(), value_.index());
  return std::get<std::string>(value_);
}

const Json::Array& Json::as_array() const {
  EQ_CHECK(is_array(), value_.index());
  return std::get<Array>(value_);
}

const Json::Object& Json::as_object() const {
  EQ_CHECK(is_object(), value_.index());
  return std::get<Object>(value_);
}

std::vector<std::string> Json::as_strings() const {
  std::vector<std::string> strings;
  for (const Json& element : as_array()) strings.push_back(element.as_string());
  return strings;
}

const Json* Json::find(std::string_view key) const {
  if (!is_object()) return nullptr;
  for (const auto& [name, value] : as_object()) {
    if (name == key) return &value;
  }
  return nullptr;
}

const Json& Json::at(std::string_view key) const {
  const Json* value = find(key);
  EQ_CHECK(value != nullptr, key);
  return *value;
}

const Json& Json::at(std::size_t index) const {
  EQ_CHECK(index < as_array().size(), index, as_array().size());
  return as_array()[index];
}

Json& Json::set(std::string_view key, Json value) {
  if (is_null()) value_ = Object{};
  EQ_CHECK(is_object(), key);
  auto& members = std::get<Object>(value_);
  const auto found =
      std::find_if(members.begin(), members.end(), [&](const auto& member) { return member.first == key; });
  if (found != members.end()) {
    found->second = std::move(value);
  } else {
    members.emplace_back(std::string(key), std::move(value));
  }
  return *this;
}

Json& Json::push(Json value) {
  if (is_null()) value_ = Array{};
  EQ_CHECK(is_array());
  std::get<Array>(value_).push_back(std::move(value));
  return *this;
}

Json make_json(const std::vector<std::string>& values) {
  Json array{Json::Array{}};
  for (const std::string& value : values) array.push(value);
  return array;
}

Json parse_json(std::string_view text, std::string_view source, const JsonLimits& limits) {
  TreeBuilder builder(text, source, limits.values);
  nlohmann::json::sax_parse(text, &builder);
  return builder.take();
}

std::string format_json(const Json& value) { return dump(value, 2) + "\n"; }

std::string format_canonical_json(const Json& value) { return dump(sort_members(value), -1); }

std::string digest_json(const Json& value) { return digest_text(format_canonical_json(value)); }

void validate_json(const Json& value, std::string_view schema_text, std::string_view source) {
  prepare_regex();
  const Json schema_value = parse_json(schema_text, "schema");
  check_array_sizes(value, schema_value, schema_value, "", source);
  const nlohmann::json schema_document = nlohmann::json::parse(schema_text);
  const nlohmann::json document = nlohmann::json::parse(dump(value, -1));
  valijson::Schema schema;
  valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(schema_document), schema);
  valijson::ValidationResults results;
  valijson::Validator validator(valijson::Validator::kStrongTypes);
  if (validator.validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results)) return;
  const auto deepest = std::max_element(results.begin(), results.end(), [](const auto& a, const auto& b) {
    return a.context.size() < b.context.size();
  });
  EQ_CHECK(deepest != results.end());
  fail_validation(value, schema_value, pointer_tokens(deepest->context), deepest->description, source);
}

Json load_json(const std::filesystem::path& path, std::string_view schema, const JsonLimits& limits) {
  Json value = parse_json(load_text(path, limits.bytes), path.string(), limits);
  validate_json(value, schema, path.string());
  return value;
}

std::string describe_json(const Json& value) {
  if (value.is_null()) return "null";
  if (value.is_array()) return fmt::format("an array of {} elements", value.as_array().size());
  if (value.is_object()) return fmt::format("an object of {} members", value.as_object().size());
  if (value.is_string() && value.as_string().size() > 60)
    return fmt::format("\"{}...\"", value.as_string().substr(0, 60));
  return dump(value, -1);
}

}  // namespace equilux
