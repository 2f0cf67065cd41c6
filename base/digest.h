// SHA-256 digests, by which every stage names what it was made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

namespace equilux {

/// Lower-case hexadecimal SHA-256 (64 characters) of the bytes.
std::string digest_text(std::string_view bytes);

/// Digest of a file's bytes. errors: InputError if it cannot be read or has more than `max_bytes`, of which
/// no more are read.
std::string digest_file(const std::filesystem::path& path,
                        std::uintmax_t max_bytes = std::numeric_limits<std::uintmax_t>::max());

}  // namespace equilux
