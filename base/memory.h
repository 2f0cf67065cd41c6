// What memory there is, asked before it is taken.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

namespace equilux {

/// Memory that this process may still take without swapping: what the system has available, or what its
/// control group leaves. Empty where the system does not say. units: bytes
std::optional<std::uint64_t> find_available_memory();

/// Runs `body` if about `bytes` are there. errors: InputError that names `what`, the bytes and what there is,
/// also where an allocation fails on the way.
void with_memory(const std::string& what, std::uint64_t bytes, const std::function<void()>& body);

}  // namespace equilux
