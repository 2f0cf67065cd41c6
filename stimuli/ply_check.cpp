// A PLY file's own numbers against its bytes, before anybody believes them.
#include "stimuli/ply_check.h"

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

struct Element {
  std::uint64_t count = 0;
  std::vector<bool> is_list;  ///< of each property
};

struct Header {
  bool has_format = false, is_text = false;
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
      : source_(path.string()), stream_(path, std::ios::binary), left_(std::filesystem::file_size(path)) {}

  bool begins_as_ply() {
    char start[3] = {};
    stream_.read(start, sizeof start);
    stream_.clear();
    stream_.seekg(0);
    return (start[0] | 32) == 'p' && (start[1] | 32) == 'l' && (start[2] | 32) == 'y';
  }
  std::uint64_t file_bytes() const { return left_; }
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
  std::uint64_t left_;
  std::size_t number_ = 0, header_bytes_ = 0;
};

bool is_of_one_byte(std::string_view type) {
  return type == "char" || type == "uchar" || type == "int8" || type == "uint8";
}

bool is_format(std::string_view word) {
  return word == "ascii" || word == "binary_little_endian" || word == "binary_big_endian";
}

void add_property(Header& header, const std::vector<std::string_view>& words, const PlyLines& lines) {
  const bool is_list = words.size() == 5 && words[1] == "list";
  if (header.elements.empty() || (!is_list && words.size() != 3))
    lines.refuse("a property of an element, with its type and name", fmt::format("{} words", words.size()));
  if (is_list && !header.is_text && !is_of_one_byte(words[2]))
    lines.refuse("lists that are counted in char or uchar", std::string(words[2].substr(0, 40)));
  header.elements.back().is_list.push_back(is_list);
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
  for (const bool is_list : element.is_list) {
    if (wanted >= words.size())
      lines.refuse("a line with all of an element's values", fmt::format("{} values", words.size()));
    if (!is_list) {
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

}  // namespace

void check_ply(const std::filesystem::path& path) {
  PlyLines lines(path);
  if (!lines.begins_as_ply()) return;
  const Header header = read_header(lines);
  if (!header.is_text) return;
  for (const Element& element : header.elements) {
    for (std::uint64_t i = 0; i < element.count; ++i) check_line(element, lines.next(), lines);
  }
}

}  // namespace equilux
