// What the fuzz targets share: bytes as a file of their own, and which end is a good one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "tests/support/temp_folder.h"

namespace equilux {

/// The one folder of a target; one file in it is written anew each time.
inline const TempFolder& fuzz_folder() {
  static const TempFolder folder(find_memory_folder());
  return folder;
}

inline std::string_view as_text(const std::uint8_t* bytes, std::size_t size) {
  return {reinterpret_cast<const char*>(bytes), size};
}

/// Reads something from outside: done, or refused with an InputError that says what was expected in which
/// file, `name` if it is the only one that is read. Any other end is a finding.
template <typename Read>
void expect_read_or_refused(std::string_view name, const Read& read) {
  try {
    read();
  } catch (const InputError& error) {
    const std::string_view words = error.what();
    EQ_CHECK(
        words.find(name) != std::string_view::npos && words.find(": expected ") != std::string_view::npos,
        words);
  }
}

}  // namespace equilux
