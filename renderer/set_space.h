// What a set takes of the disk.
#pragma once

#include <filesystem>

#include "protocols/study.h"
#include "renderer/work.h"

namespace equilux {

/// Layers and pictures that are wanted, about: what is black in a layer takes next to nothing, what is not
/// can hardly be compressed. shape of `costs`: every world of `wanted`; units: bytes
std::uint64_t estimate_set_bytes(const Study& study, const std::map<WorldKey, WorldCosts>& costs,
                                 const Wanted& wanted);

/// Asks before hours of work whether the folder's disk has so much left. Where the system does not say it
/// may. units: bytes; errors: InputError
void check_space(const std::filesystem::path& folder, std::uint64_t bytes);

}  // namespace equilux
