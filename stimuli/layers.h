// layers.json: the EXR layers that were rendered, each with its digest and what it was made from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "base/json.h"
#include "protocols/condition.h"

namespace equilux {

struct LayerRecord {
  std::string file;            ///< relative to the study folder
  std::string digest;          ///< of the EXR file
  std::string made_from;       ///< digest of scene part, parameters and seed
  std::int64_t vpl_count = 0;  ///< true number of VPLs; 0 where there are none
  Json vpls = {};              ///< with VPLs: method, its rule, cut sizes, rays, measured error; else null
  Json errors_1e5 = {};        ///< of a lightcut: the absolute errors measured, sorted; else null
  Json reference = {};         ///< of a reference's indirect light: method, its numbers, its check; else null
  std::string isa = {};        ///< instruction set of the kernels that made it; empty if an older program did
};

struct Layers {
  std::string study_name;
  std::string study_digest;
  std::uint64_t seed = 0;
  std::map<std::string, LayerRecord> by_name;
};

/// Contents of a family's layers.
inline constexpr const char* kFamilyContents[] = {"background", "coverage", "direct", "indirect",
                                                  "standard_error"};

/// Names of a family's layers: those of the reference's key with what they hold, such as
/// G1-MR-ind-ref-v0.background. A VPL layer has the name of its condition.
std::string layer_name(const Family& family, const std::string& content);

/// Name of the layer of a VPL picture: the key of its condition, not normalised.
std::string vpl_layer_name(Condition condition);

/// errors: InputError
Layers load_layers(const std::filesystem::path& path);
/// errors: StoreError
void save_layers(const Layers& layers, const std::filesystem::path& path);

}  // namespace equilux
