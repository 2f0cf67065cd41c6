// The one file that knows nlohmann-json and valijson.
#include "base/json.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <locale>
#include <map>
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
#include "base/json_mismatch.h"

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

// What every JSON library writes between quotes as it is.
bool is_plain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char character) {
    return character >= ' ' && character <= '~' && character != '"' && character != '\\';
  });
}

// Writes a value as nlohmann-json would, whose trees take ten times as long to make.
class Writer {
 public:
  /// Without `indent` on one line, members sorted.
  explicit Writer(std::optional<std::size_t> indent) : indent_(indent) {}

  void add(const Json& value) {
    if (value.is_array()) {
      add_all(value.as_array(), '[', ']', [&](const Json& element) { add(element); });
    } else if (!value.is_object()) {
      add_scalar(value);
    } else if (indent_) {
      add_all(value.as_object(), '{', '}', [&](const auto& member) { add_member(member); });
    } else {
      add_all(sort_members(value.as_object()), '{', '}', [&](const auto* member) { add_member(*member); });
    }
  }
  std::string take() { return std::move(text_); }

 private:
  using Member = Json::Object::value_type;

  static std::vector<const Member*> sort_members(const Json::Object& members) {
    std::vector<const Member*> sorted;
    for (const Member& member : members) sorted.push_back(&member);
    std::sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) { return a->first < b->first; });
    return sorted;
  }

  void add_scalar(const Json& value) {
    if (value.is_null()) {
      text_ += "null";
    } else if (value.is_bool()) {
      text_ += value.as_bool() ? "true" : "false";
    } else if (value.is_integer()) {
      text_ += fmt::format_int(value.as_int()).c_str();
    } else if (value.is_string()) {
      add_string(value.as_string());
    } else {
      EQ_CHECK(std::isfinite(value.as_double()), value.as_double());
      text_ += nlohmann::json(value.as_double()).dump();
    }
  }
  void add_string(const std::string& value) {
    if (is_plain(value)) {
      text_.append(1, '"').append(value).append(1, '"');
    } else {
      text_ += nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }
  }
  void add_member(const Member& member) {
    add_string(member.first);
    text_ += indent_ ? ": " : ":";
    add(member.second);
  }
  void add_all(const auto& values, char begin, char end, const auto& add_one) {
    text_ += begin;
    ++depth_;
    const char* separator = "";
    for (const auto& value : values) {
      text_ += separator;
      separator = ",";
      begin_line();
      add_one(value);
    }
    --depth_;
    if (!values.empty()) begin_line();
    text_ += end;
  }
  void begin_line() {
    if (indent_) text_.append(1, '\n').append(depth_ * *indent_, ' ');
  }

  std::optional<std::size_t> indent_;
  std::size_t depth_ = 0;
  std::string text_;
};

std::string write(const Json& value, std::optional<std::size_t> indent) {
  Writer writer(indent);
  writer.add(value);
  return writer.take();
}

nlohmann::json to_nlohmann(const Json& value) {
  if (value.is_null()) return nullptr;
  if (value.is_bool()) return value.as_bool();
  if (value.is_integer()) return value.as_int();
  if (value.is_number()) return value.as_double();
  if (value.is_string()) return value.as_string();
  if (value.is_array()) {
    auto array = nlohmann::json::array();
    for (const Json& element : value.as_array()) array.push_back(to_nlohmann(element));
    return array;
  }
  auto object = nlohmann::json::object();
  for (const auto& [key, member] : value.as_object()) object.emplace(key, to_nlohmann(member));
  return object;
}

// A schema as valijson has it, with the regular expressions that were met.
struct ReadySchema {
  explicit ReadySchema(std::string_view text) : value(parse_json(text, "schema")) {
    const nlohmann::json document = to_nlohmann(value);
    valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(document), schema);
  }
  Json value;
  valijson::Schema schema;
  valijson::Validator validator{valijson::Validator::kStrongTypes};
};

// Each is read once by each thread: of the program's few schemas that takes longer than a file's validation.
ReadySchema& find_schema(std::string_view text) {
  thread_local std::map<std::string, ReadySchema, std::less<>> ready;
  const auto known = ready.find(text);
  return known != ready.end() ? known->second : ready.try_emplace(std::string(text), text).first->second;
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

std::string format_json(const Json& value) { return write(value, 2) + "\n"; }

std::string format_canonical_json(const Json& value) { return write(value, std::nullopt); }

std::string digest_json(const Json& value) { return digest_text(format_canonical_json(value)); }

void validate_json(const Json& value, std::string_view schema_text, std::string_view source) {
  prepare_regex();
  ReadySchema& ready = find_schema(schema_text);
  check_array_sizes(value, ready.value, source);
  const nlohmann::json document = to_nlohmann(value);
  valijson::ValidationResults results;
  if (ready.validator.validate(ready.schema, valijson::adapters::NlohmannJsonAdapter(document), &results))
    return;
  const auto deepest = std::max_element(results.begin(), results.end(), [](const auto& a, const auto& b) {
    return a.context.size() < b.context.size();
  });
  EQ_CHECK(deepest != results.end());
  fail_validation(value, ready.value, deepest->context, deepest->description, source);
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
  if (value.is_string() && value.as_string().size() > 60) {
    std::string beginning = write(Json(value.as_string().substr(0, 60)), std::nullopt);
    return beginning.insert(beginning.size() - 1, "...");
  }
  return write(value, std::nullopt);
}

}  // namespace equilux
