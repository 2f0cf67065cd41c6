// Quoting where a field needs it, and reading it back.
#include "analysis/csv.h"

#include "base/error.h"

namespace equilux {
namespace {

std::string quote(const std::string& field) {
  if (field.find_first_of(",\"\r\n") == std::string::npos) return field;
  std::string quoted = "\"";
  for (char character : field) quoted += character == '"' ? "\"\"" : std::string(1, character);
  return quoted + "\"";
}

std::string format_line(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (i > 0) line += ',';
    line += quote(fields[i]);
  }
  return line + "\n";
}

class CsvReader {
 public:
  CsvReader(std::string_view text, std::string_view source) : text_(text), source_(source) {}

  bool at_end() const { return position_ == text_.size(); }
  std::size_t line() const { return line_; }

  std::vector<std::string> read_line() {
    std::vector<std::string> fields{read_field()};
    while (!at_end() && text_[position_] == ',') {
      ++position_;
      fields.push_back(read_field());
    }
    if (at_end() || text_[position_] != '\n') fail("a line feed");
    ++position_;
    ++line_;
    return fields;
  }

 private:
  std::string read_field() {
    if (!at_end() && text_[position_] == '"') return read_quoted();
    const std::size_t end = std::min(text_.find_first_of(",\"\r\n", position_), text_.size());
    std::string field(text_.substr(position_, end - position_));
    position_ = end;
    return field;
  }

  std::string read_quoted() {
    std::string field;
    for (++position_; !at_end(); ++position_) {
      if (text_[position_] != '"') {
        line_ += text_[position_] == '\n' ? 1 : 0;
        field += text_[position_];
      } else if (position_ + 1 < text_.size() && text_[position_ + 1] == '"') {
        field += text_[++position_];
      } else {
        ++position_;
        return field;
      }
    }
    fail("a closing quotation mark");
  }

  [[noreturn]] void fail(std::string_view expected) const {
    throw InputError(source_, fmt::format("line {}", line_), expected,
                     at_end() ? "the end of the file" : fmt::format("\"{}\"", text_.substr(position_, 1)));
  }

  std::string_view text_;
  std::string_view source_;
  std::size_t position_ = 0;
  std::size_t line_ = 1;
};

}  // namespace

std::string format_csv(const Table& table) {
  std::string text = format_line(table.columns);
  for (const auto& row : table.rows) {
    EQ_CHECK(row.size() == table.columns.size(), row.size(), table.columns.size());
    text += format_line(row);
  }
  return text;
}

Table parse_csv(std::string_view text, std::string_view source) {
  CsvReader reader(text, source);
  Table table{reader.read_line(), {}};
  while (!reader.at_end()) {
    const std::size_t line = reader.line();
    table.rows.push_back(reader.read_line());
    if (table.rows.back().size() != table.columns.size()) {
      throw InputError(source, fmt::format("line {}", line), fmt::format("{} fields", table.columns.size()),
                       fmt::format("{}", table.rows.back().size()));
    }
  }
  return table;
}

}  // namespace equilux
