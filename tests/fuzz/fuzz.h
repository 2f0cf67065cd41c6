// What the fuzz targets share: bytes as a file of their own, and which end is a good one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "base/error.h"

namespace equilux {

/// A folder of this program in memory where there is /dev/shm, removed at its end.
class FuzzFolder {
 public:
  FuzzFolder() {
    std::error_code error;
    const std::filesystem::path memory = "/dev/shm";
    const bool has_memory = std::filesystem::is_directory(memory, error);
    std::string form =
        ((has_memory ? memory : std::filesystem::temp_directory_path()) / "equilux-fuzz-XXXXXX").string();
    if (!::mkdtemp(form.data())) std::abort();
    path_ = form;
  }
  ~FuzzFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  FuzzFolder(const FuzzFolder&) = delete;
  FuzzFolder& operator=(const FuzzFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// Writes a file anew; gives its path.
  std::filesystem::path write(const std::string& name, std::string_view bytes) const {
    const auto path = path_ / name;
    std::ofstream stream(path, std::ios::binary | std::ios::trunc);
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream.flush()) std::abort();
    return path;
  }

 private:
  std::filesystem::path path_;
};

/// The one folder of a target; one file in it is written anew each time.
inline const FuzzFolder& fuzz_folder() {
  static const FuzzFolder folder;
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
