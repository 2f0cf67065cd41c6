// Where a value is not what its schema says, in words.
#include "base/json_mismatch.h"

#include <algorithm>
#include <optional>

#include "base/error.h"

namespace equilux {
namespace {

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

// valijson compares all elements of an array with one another and keeps a line for each that fails, before it
// counts them.
void check_sizes_below(const Json& value, const Json& schema_part, const Json& schema,
                       const std::string& place, std::string_view source) {
  const Json& wanted = resolve(schema, schema_part);
  if (value.is_array()) {
    const Json* most = wanted.find("maxItems");
    if (most && value.as_array().size() > static_cast<std::size_t>(most->as_int()))
      throw InputError(source, place, describe_schema(wanted), describe_json(value));
    const Json* items = wanted.find("items");
    for (std::size_t i = 0; items && i < value.as_array().size(); ++i) {
      if (value.at(i).is_array() || value.at(i).is_object())
        check_sizes_below(value.at(i), *items, schema, fmt::format("{}/{}", place, i), source);
    }
  }
  const Json* properties = value.is_object() ? wanted.find("properties") : nullptr;
  if (!properties) return;
  for (const auto& [name, member] : value.as_object()) {
    if (const Json* part = properties->find(name))
      check_sizes_below(member, *part, schema, place + "/" + escape_pointer(name), source);
  }
}

}  // namespace

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

void fail_validation(const Json& value, const Json& schema, const std::vector<std::string>& context,
                     const std::string& description, std::string_view source) {
  const std::vector<std::string> tokens = pointer_tokens(context);
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

void check_array_sizes(const Json& value, const Json& schema, std::string_view source) {
  check_sizes_below(value, schema, schema, "", source);
}

}  // namespace equilux
