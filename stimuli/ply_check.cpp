// A PLY file's own numbers against its bytes, before anybody believes them.
#include "stimuli/ply_check.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace equilux {
namespace {

constexpr std::size_t kMaxHeaderBytes = 1 << 16;

struct Property {
  bool is_list = false;
  std::string_view count_type;  ///< of a list
  std::size_t bytes = 0;        ///< of a value
};

struct Element {
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
  explicit PlyLines(const std::filesystem::path& path)
      : source_(path.string()),
        stream_(path, std::ios::binary),
        file_bytes_(std::filesystem::file_size(path)) {}

  bool begins_as_ply() {
    char start[3] = {};
    stream_.read(start, sizeof start);
    stream_.clear();
    stream_.seekg(0);
    return (start[0] | 32) == 'p' && (start[1] | 32) == 'l' && (start[2] | 32) == 'y';
  }
  std::uint64_t file_bytes() const { return file_bytes_; }
  /// What follows the lines that were read.
  std::ifstream& stream() { return stream_; }
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
  std::ifstream stream_;
  std::uint64_t file_bytes_;
  std::size_t number_ = 0, header_bytes_ = 0;
};

struct Type {
  std::string_view name;
  std::size_t bytes;
  bool is_count;  ///< an integer; one of a byte with a sign would be taken for a huge number
};
constexpr Type kTypes[] = {
    {"char", 1, false},  {"int8", 1, false},    {"uchar", 1, true},   {"uint8", 1, true},
    {"short", 2, true},  {"int16", 2, true},    {"ushort", 2, true},  {"uint16", 2, true},
    {"int", 4, true},    {"int32", 4, true},    {"uint", 4, true},    {"uint32", 4, true},
    {"float", 4, false}, {"float32", 4, false}, {"double", 8, false}, {"float64", 8, false}};

const Type* find_type(std::string_view name) {
  const auto* found =
      std::find_if(std::begin(kTypes), std::end(kTypes), [&](const Type& type) { return type.name == name; });
  return found == std::end(kTypes) ? nullptr : found;
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
  header.elements.back().properties.push_back({is_list, is_list ? count->name : "", value->bytes});
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
      header.elements.push_back({*count, {}});
    } else if (kind == "property") {
      add_property(header, words, lines);
    } else if (kind != "comment" && kind != "obj_info" &&
               !(words.size() == 1 && (kind == "ply" || kind == "PLY"))) {
      lines.refuse("ply, one format, then element, property, end_header; comment, obj_info", "another line");
    }
  }
  return header;
}

void check_line(const Element& element, const std::vector<std::string_view>& words, const PlyLines& lines) {
  std::uint64_t wanted = 0;
  for (const Property& property : element.properties) {
    if (wanted >= words.size())
      lines.refuse("a line with all of an element's values", fmt::format("{} values", words.size()));
    if (!property.is_list) {
      ++wanted;
      continue;
    }
    const auto count = read_count(words[wanted]);
    if (!count || *count >= words.size())
      lines.refuse("a list that is as long as it says", fmt::format("{} values", words.size()));
    wanted += 1 + *count;
  }
  if (wanted != words.size()) lines.refuse(fmt::format("{} values", wanted), fmt::format("{}", words.size()));
}

// Walks over the values of a binary body; errors name the element.
class PlyBytes {
 public:
  PlyBytes(std::string source, std::ifstream& stream, std::uint64_t left, bool is_big_endian)
      : source_(std::move(source)), stream_(stream), left_(left), is_big_endian_(is_big_endian) {}

  void walk_all(const Element& element) {
    std::uint64_t bytes = 0;
    bool has_list = false;
    for (const Property& property : element.properties) {
      bytes += property.bytes;
      has_list |= property.is_list;
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
      skip(property.is_list ? take_count(property.count_type) : 1, property.bytes);
  }
  std::uint64_t take_count(std::string_view type) {
    const std::size_t bytes = find_type(type)->bytes;
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < bytes; ++i) {
      const int byte = left_ > 0 ? stream_.get() : std::ifstream::traits_type::eof();
      if (byte == std::ifstream::traits_type::eof()) refuse("the end of the file");
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
  std::ifstream& stream_;
  std::uint64_t left_, index_ = 0;
  bool is_big_endian_;
};

}  // namespace

void check_ply(const std::filesystem::path& path) {
  PlyLines lines(path);
  if (!lines.begins_as_ply()) return;
  const Header header = read_header(lines);
  if (!header.is_text) {
    PlyBytes body(path.string(), lines.stream(), lines.count_left(), header.is_big_endian);
    for (const Element& element : header.elements) body.walk_all(element);
    return;
  }
  for (const Element& element : header.elements) {
    for (std::uint64_t i = 0; i < element.count; ++i) check_line(element, lines.next_of_body(), lines);
  }
}

}  // namespace equilux
