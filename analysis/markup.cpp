// The small part of markup that both the graphs and the page need.
#include "analysis/markup.h"

#include <algorithm>
#include <set>

#include "base/error.h"

namespace equilux {

std::string escape_xml(std::string_view text) {
  std::string escaped;
  for (char character : text) {
    switch (character) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += character;
    }
  }
  return escaped;
}

std::string fill_template(std::string_view text, const std::map<std::string, std::string>& values) {
  std::string filled;
  std::set<std::string> used;
  for (;;) {
    const std::size_t open = text.find("{{");
    filled += text.substr(0, open);
    if (open == std::string_view::npos) break;
    const std::size_t close = text.find("}}", open);
    EQ_CHECK(close != std::string_view::npos, open);
    const std::string name(text.substr(open + 2, close - open - 2));
    const auto found = values.find(name);
    EQ_CHECK(found != values.end(), name);
    filled += found->second;
    used.insert(name);
    text.remove_prefix(close + 2);
  }
  EQ_CHECK(used.size() == values.size(), used.size(), values.size());
  return filled;
}

std::vector<std::string> wrap_words(std::string_view text, std::size_t most_letters) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word(text.substr(begin, end - begin));
    if (lines.empty() || lines.back().size() + 1 + word.size() > most_letters) {
      lines.push_back(word);
    } else {
      lines.back() += " " + word;
    }
    begin = end + 1;
  }
  return lines;
}

}  // namespace equilux
