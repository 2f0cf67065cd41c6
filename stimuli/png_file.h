// PNG files of 8-bit sRGB.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "stimuli/image.h"

namespace equilux {

/// Loads a PNG of any colour type as 8-bit sRGB; a file that names another gamma is converted.
/// errors: InputError for a missing, damaged or larger than 16,384 x 16,384 file, and for one that declares
/// more pixels than its bytes can hold.
LdrImage load_png(const std::filesystem::path& path);

/// The same of a file's bytes; `name` is the file's in messages.
LdrImage decode_png(std::string_view bytes, const std::string& name);

/// As a PNG file says it first, without reading more; 0 x 0 where it is none.
PixelSize load_png_size(const std::filesystem::path& path);

/// The bytes of a PNG file; the same picture always gives the same ones.
std::string encode_png(const LdrImage& image);

/// errors: StoreError
void save_png(const LdrImage& image, const std::filesystem::path& path);

}  // namespace equilux
