// What a JSON value is told that is not as its schema says; for json.cpp.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"

namespace equilux {

/// A member's name as a JSON pointer has it.
std::string escape_pointer(std::string_view token);

/// Throws what stands at a place and what the schema wants there. `context` is the place in valijson's words:
/// <root>, ["name"], [0]; `description` is valijson's, for schemas that the plain keywords do not explain.
[[noreturn]] void fail_validation(const Json& value, const Json& schema,
                                  const std::vector<std::string>& context, const std::string& description,
                                  std::string_view source);

/// errors: InputError for an array of more elements than the schema's maxItems
void check_array_sizes(const Json& value, const Json& schema, std::string_view source);

}  // namespace equilux
