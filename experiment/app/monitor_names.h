// What monitors and their colour profiles are called: text alone, without a window system.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace equilux {

/// Names by which each monitor can be chosen, in their order: the second of one name gets "#2" behind it.
std::vector<std::string> label_monitors(const std::vector<std::string>& names);

/// The description of a colour profile, of printable ASCII alone, at most 100 letters; empty where there is
/// none. source: ICC.1:2010, 10.13 multiLocalizedUnicodeType; ICC.1:2001, 6.5.17 textDescriptionType
std::string find_profile_name(std::string_view profile);

}  // namespace equilux
