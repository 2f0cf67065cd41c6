// Text into SVG and HTML: escaping, and templates whose every place is filled.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace equilux {

/// The five characters that XML gives a meaning.
std::string escape_xml(std::string_view text);

/// Replaces each {{name}} by its value. A name without a value, or a value without a place, is our bug.
std::string fill_template(std::string_view text, const std::map<std::string, std::string>& values);

/// Lines of whole words, of at most so many letters where no word alone has more.
std::vector<std::string> wrap_words(std::string_view text, std::size_t most_letters);

}  // namespace equilux
