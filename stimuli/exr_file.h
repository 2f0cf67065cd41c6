// EXR files: linear float layers with the names and digests that they carry.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "stimuli/image.h"

namespace equilux {

using ExrMetadata = std::map<std::string, std::string>;

struct ExrFile {
  HdrImage image;
  ExrMetadata metadata;  ///< the string attributes
};

/// Reads channels R, G, B, or Y alone, of one part in scan lines, compressed without loss. errors: InputError
/// for a missing, damaged, other or larger than 16,384 x 16,384 file, for one that declares more pixels than
/// its bytes can hold, for values that are not finite, and, where a size is asked for, for another size or
/// more channels.
ExrFile load_exr(const std::filesystem::path& path, std::optional<PixelSize> size = {});

/// 32-bit float, ZIP. The same picture and metadata always give the same bytes. A value that is not finite is
/// our bug.
std::string encode_exr(const HdrImage& image, const ExrMetadata& metadata);

/// errors: StoreError
void save_exr(const HdrImage& image, const ExrMetadata& metadata, const std::filesystem::path& path);

}  // namespace equilux
