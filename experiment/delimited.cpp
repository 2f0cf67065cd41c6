// Quoting where a field needs it.
#include "experiment/delimited.h"

namespace equilux {
namespace {

std::string quote(const std::string& field, char separator) {
  if (field.find_first_of(std::string("\"\r\n") + separator) == std::string::npos) return field;
  std::string quoted = "\"";
  for (const char c : field) {
    if (c == '"') quoted += c;
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

std::string format_fields(const std::vector<std::string>& fields, char separator,
                          const std::string& missing) {
  std::string line;
  for (const std::string& field : fields) {
    if (&field != &fields.front()) line += separator;
    line += field.empty() ? missing : quote(field, separator);
  }
  return line + '\n';
}

}  // namespace equilux
