// A PLY file's own numbers against its bytes, before anybody believes them.
#include "stimuli/ply_check.h"

#include <algorithm>
#include <boost/interprocess/streams/bufferstream.hpp>
#include <charconv>
#include <cstdint>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace equilux {
namespace {

constexpr std::size_t kMaxHeaderBytes = 1 << 16;

struct Type {
  std::string_view name;
  std::size_t bytes;
  bool is_count;  ///< an integer; one of a byte with a sign would be taken for a huge number
  std::int64_t least = 0, most = 0;  ///< of an integer
  bool is_integer() const { return most > 0; }
};
constexpr Type kTypes[] = {{"char", 1, false, -128, 127},
                           {"int8", 1, false, -128, 127},
                           {"uchar", 1, true, 0, 255},
                           {"uint8", 1, true, 0, 255},
                           {"short", 2, true, -32768, 32767},
                           {"int16", 2, true, -32768, 32767},
                           {"ushort", 2, true, 0, 65535},
                           {"uint16", 2, true, 0, 65535},
                           {"int", 4, true, -2147483648, 2147483647},
                           {"int32", 4, true, -2147483648, 2147483647},
                           {"uint", 4, true, 0, 4294967295},
                           {"uint32", 4, true, 0, 4294967295},
                           {"float", 4, false},
                           {"float32", 4, false},
                           {"double", 8, false},
                           {"float64", 8, false}};

const Type* find_type(std::string_view name) {
  const auto* found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const Type& type) { return type.name == name; });
  return found == std::end(kTypes) ? nullptr : found;
}

struct Property {
  std::string name;
  const Type* type = nullptr;        ///< of a value
  const Type* count_type = nullptr;  ///< of a list
  bool is_list() const { return count_type != nullptr; }
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool has_format = false, is_text = false, is_big_endian = false;
  std::vector<Element> elements;
};

// The words of a line between blanks.
std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t start = line.find_first_not_of(" \t"); start != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(" \t", start), line.size());
    words.push_back(line.substr(start, end - start));
    start = line.find_first_not_of(" \t", end);
  }
  return words;
}

std::optional<std::uint64_t> read_count(std::string_view word) {
  std::uint64_t count = 0;
  const char* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, count);
  return read.ec == std::errc() && read.ptr == end ? std::optional(count) : std::nullopt;
}

// Reads a file line by line; errors name the line.
class PlyLines {
 public:
  PlyLines(const std::string& source, const std::string& bytes)
      : source_(source), stream_(bytes.data(), bytes.size()), file_bytes_(bytes.size()) {}

  bool begins_as_ply() {
    char start[3] = {};
    stream_.read(start, sizeof start);
    stream_.clear();
    stream_.seekg(0);
    return (start[0] | 32) == 'p' && (start[1] | 32) == 'l' && (start[2] | 32) == 'y';
  }
  std::uint64_t file_bytes() const { return file_bytes_; }
  /// What follows the lines that were read.
  std::istream& stream() { return stream_; }
  std::uint64_t count_left() { return file_bytes_ - static_cast<std::uint64_t>(stream_.tellg()); }
  /// The words of the next line; empty at the end.
  std::vector<std::string_view> next() {
    ++number_;
    line_.clear();
    std::getline(stream_, line_);
    if (line_.ends_with('\r')) line_.pop_back();
    // assimp ends lines at some of these.
    for (char c : line_) {
      if (static_cast<unsigned char>(c) < ' ' && c != '\t') refuse("text", "a control character");
    }
    return split(line_);
  }
  /// The same without blank lines.
  std::vector<std::string_view> next_of_body() {
    auto words = next();
    while (words.empty() && stream_) words = next();
    return words;
  }
  /// The same within a header.
  std::vector<std::string_view> next_of_header() {
    auto words = next();
    header_bytes_ += line_.size() + 1;
    if (!stream_ || header_bytes_ > kMaxHeaderBytes)
      throw InputError(source_, "", "a PLY header that ends within 65,536 bytes", "none");
    return words;
  }
  [[noreturn]] void refuse(const std::string& expected, const std::string& got) const {
    throw InputError(source_, fmt::format("line {}", number_), expected, got);
  }

 private:
  std::string source_, line_;
  boost::interprocess::ibufferstream stream_;
  std::uint64_t file_bytes_;
  std::size_t number_ = 0, header_bytes_ = 0;
};

// assimp reads vertices and faces whatever stands before them, of an element twice the last, and of strips
// the first triangle.
void check_order(const Header& header, const PlyLines& lines) {
  for (std::size_t i = 0; i < header.elements.size(); ++i) {
    const std::string& name = header.elements[i].name;
    const auto known = [&](const Element& other) { return other.name == name; };
    if ((i == 0) != (name == "vertex"))
      lines.refuse("vertex as the first element, once", fmt::format("the element {}", name.substr(0, 40)));
    if (name == "tristrips") lines.refuse("surfaces as faces", "tristrips");
    if (std::any_of(header.elements.begin(), header.elements.begin() + static_cast<std::ptrdiff_t>(i), known))
      lines.refuse("each element once", name.substr(0, 40) + " again");
  }
}

// The one property of a name; without it assimp takes zeros.
const Property& find_property(const Element& element, std::initializer_list<std::string_view> names,
                              const PlyLines& lines) {
  const auto is_named = [&](const Property& property) {
    return std::find(names.begin(), names.end(), property.name) != names.end();
  };
  const auto& properties = element.properties;
  const auto found = std::find_if(properties.begin(), properties.end(), is_named);
  if (found == properties.end() || std::count_if(properties.begin(), properties.end(), is_named) > 1)
    lines.refuse(fmt::format("one property {} of {}", fmt::join(names, " or "), element.name),
                 found == properties.end() ? "none" : "more");
  return *found;
}

void check_shape(const Header& header, const PlyLines& lines) {
  check_order(header, lines);
  for (const Element& element : header.elements) {
    if (element.name == "vertex") {
      for (const char* axis : {"x", "y", "z"}) {
        if (find_property(element, {axis}, lines).is_list())
          lines.refuse(fmt::format("a number as {} of vertex", axis), "a list");
      }
    } else if (element.name == "face") {
      const Property& corners = find_property(element, {"vertex_indices", "vertex_index"}, lines);
      if (!corners.is_list() || !corners.type->is_integer())
        lines.refuse("a list of integers as corners of face", std::string(corners.type->name));
    }
  }
}

bool is_format(std::string_view word) {
  return word == "ascii" || word == "binary_little_endian" || word == "binary_big_endian";
}

void add_property(Header& header, const std::vector<std::string_view>& words, const PlyLines& lines) {
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (header.elements.empty() || (!is_list && words.size() != 3))
    lines.refuse("a property of an element, with its type and name", fmt::format("{} words", words.size()));
  const Type *value = find_type(words[is_list ? 3 : 1]), *count = is_list ? find_type(words[2]) : nullptr;
  if (!value || (is_list && !count))
    lines.refuse("types such as uchar, int and float", std::string(words[!is_list ? 1
                                                                         : count  ? 3
                                                                                  : 2]
                                                                       .substr(0, 40)));
  if (is_list && !header.is_text && !count->is_count)
    lines.refuse("lists that are counted in uchar, short, ushort, int or uint", std::string(count->name));
  header.elements.back().properties.push_back({std::string(words.back()), value, count});
}

Header read_header(PlyLines& lines) {
  Header header;
  std::uint64_t declared = 0;
  for (auto words = lines.next_of_header(); words.empty() || words[0] != "end_header";
       words = lines.next_of_header()) {
    const std::string_view kind = words.empty() ? std::string_view() : words[0];
    if (kind == "format" && words.size() == 3 && !header.has_format && is_format(words[1])) {
      header.has_format = true;
      header.is_text = words[1] == "ascii";
      header.is_big_endian = words[1] == "binary_big_endian";
    } else if (kind == "element" && words.size() == 3 && header.has_format) {
      const auto count = read_count(words[2]);
      if (!count || *count > lines.file_bytes() - declared) {
        lines.refuse(fmt::format("at most as many elements as the file has bytes, {}", lines.file_bytes()),
                     std::string(words[2].substr(0, 40)));
      }
      declared += *count;
      header.elements.push_back({std::string(words[1]), *count, {}});
    } else if (kind == "property") {
      add_property(header, words, lines);
    } else if (kind != "comment" && kind != "obj_info" &&
               !(words.size() == 1 && (kind == "ply" || kind == "PLY"))) {
      lines.refuse("ply, one format, then element, property, end_header; comment, obj_info", "another line");
    }
  }
  check_shape(header, lines);
  return header;
}

// assimp takes the beginning of a word for the whole, leaves out what has no such beginning, and lets
// integers overflow.
void check_word(const Type& type, std::string_view word, const PlyLines& lines) {
  const std::string_view digits =
      word.starts_with('+') && word.size() > 1 && word[1] != '-' ? word.substr(1) : word;
  const char* end = digits.data() + digits.size();
  double number = 0;
  std::int64_t whole = 0;
  const auto read = type.is_integer() ? std::from_chars(digits.data(), end, whole)
                                      : std::from_chars(digits.data(), end, number);
  const bool is_read = read.ptr == end && (read.ec == std::errc() ||
                                           (!type.is_integer() && read.ec == std::errc::result_out_of_range));
  if (!is_read || (type.is_integer() && (whole < type.least || whole > type.most)))
    lines.refuse(fmt::format("a value of type {}", type.name), fmt::format("\"{}\"", word.substr(0, 40)));
}

void check_line(const Element& element, const std::vector<std::string_view>& words, const PlyLines& lines) {
  std::uint64_t wanted = 0;
  for (const Property& property : element.properties) {
    if (wanted >= words.size())
      lines.refuse("a line with all of an element's values", fmt::format("{} values", words.size()));
    std::uint64_t values = 1;
    if (property.is_list()) {
      const auto count = read_count(words[wanted]);
      if (!count || *count >= words.size() - wanted)
        lines.refuse("a list that is as long as it says", fmt::format("{} values", words.size()));
      values = *count;
      ++wanted;
    }
    for (; values > 0; --values) check_word(*property.type, words[wanted++], lines);
  }
  if (wanted != words.size()) lines.refuse(fmt::format("{} values", wanted), fmt::format("{}", words.size()));
}

// Walks over the values of a binary body; errors name the element.
class PlyBytes {
 public:
  PlyBytes(std::string source, std::istream& stream, std::uint64_t left, bool is_big_endian)
      : source_(std::move(source)), stream_(stream), left_(left), is_big_endian_(is_big_endian) {}

  void walk_all(const Element& element) {
    std::uint64_t bytes = 0;
    bool has_list = false;
    for (const Property& property : element.properties) {
      bytes += property.type->bytes;
      has_list |= property.is_list();
    }
    index_ = 0;
    if (!has_list) {
      skip(element.count, bytes);
      return;
    }
    for (; index_ < element.count; ++index_) walk(element);
  }

 private:
  void walk(const Element& element) {
    for (const Property& property : element.properties)
      skip(property.is_list() ? take_count(property.count_type->bytes) : 1, property.type->bytes);
  }
  std::uint64_t take_count(std::size_t bytes) {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const int byte = left_ > 0 ? stream_.get() : std::istream::traits_type::eof();
      if (byte == std::istream::traits_type::eof()) refuse("the end of the file");
      --left_;
      count |= static_cast<std::uint64_t>(byte) << 8 * (is_big_endian_ ? bytes - 1 - i : i);
    }
    return count;
  }
  void skip(std::uint64_t count, std::uint64_t bytes) {
    if (bytes > 0 && count > left_ / bytes) refuse(fmt::format("{} bytes for {} values", left_, count));
    stream_.ignore(static_cast<std::streamsize>(count * bytes));
    left_ -= count * bytes;
  }
  [[noreturn]] void refuse(const std::string& got) const {
    throw InputError(source_, fmt::format("element {} of its kind", index_), "as much as the header says",
                     got);
  }

  std::string source_;
  std::istream& stream_;
  std::uint64_t left_, index_ = 0;
  bool is_big_endian_;
};

}  // namespace

bool check_ply(const std::string& source, const std::string& bytes) {
  PlyLines lines(source, bytes);
  if (!lines.begins_as_ply()) return false;
  const Header header = read_header(lines);
  if (!header.is_text) {
    PlyBytes body(source, lines.stream(), lines.count_left(), header.is_big_endian);
    for (const Element& element : header.elements) body.walk_all(element);
    return true;
  }
  for (const Element& element : header.elements) {
    for (std::uint64_t i = 0; i < element.count; ++i) check_line(element, lines.next_of_body(), lines);
  }
  return true;
}

}  // namespace equilux
