// manifest.json: the pictures that may be shown, each with its digest and what it was made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "protocols/study.h"

namespace equilux {

/// A picture file and its origin.
struct PictureRecord {
  std::string file;       ///< relative to the study folder
  std::string digest;     ///< of the PNG file
  std::string made_from;  ///< digest of its layers and tone curve
  Json standard_error;    ///< references: object_mean, object_p99, outside_mean in display steps; else null
  Json reference = {};    ///< references: how their indirect light was made, and its check; else null
  Json vpls = {};  ///< VPL pictures: count, method, its rule, cut sizes, rays, measured error; else null
};

/// Raised whenever pictures by the local operator change.
inline constexpr int kLocalToneVersion = 1;

/// The tone curve of a family, from its reference. units: those of the layers for log_average, white and
/// delta.
struct ToneRecord {
  double log_average = 0;
  double white = 0;
  double delta = 0;
  double key = 0;
  std::string exposure;
  std::string tone_operator = "global";
  bool operator==(const ToneRecord&) const = default;
};

struct Manifest {
  std::string study_name;
  std::string study_digest;
  std::uint64_t seed = 0;
  int width = 0;
  int height = 0;
  std::map<std::string, ToneRecord> tones;        ///< by key of the reference
  std::map<std::string, PictureRecord> pictures;  ///< by key of picture or reference
  /// Of the references; what they have is their standard_error.
  std::optional<NoiseTarget> noise_target = std::nullopt;
};

/// errors: InputError
Manifest load_manifest(const std::filesystem::path& path);

/// errors: StoreError
void save_manifest(const Manifest& manifest, const std::filesystem::path& path);

/// Digest of the entries of these pictures (key and file digest, sorted): what a session that shows them
/// depends on. errors: InputError naming `source` and the first picture that is missing.
std::string digest_pictures(const Manifest& manifest, const std::vector<std::string>& keys,
                            const std::string& source);

}  // namespace equilux
