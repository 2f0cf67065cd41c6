// What memory there is, asked before it is taken.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace equilux {

/// Memory that this process may still take without swapping: what the system has available, or what its
/// control groups leave. Empty where the system does not say. units: bytes
std::optional<std::uint64_t> find_available_memory();

/// What control groups leave to a process: the least over its group and all above it, of version 2 or 1.
/// `mount` is where they stand (/sys/fs/cgroup), `own` the file that names the process's (/proc/self/cgroup).
/// Empty where none has a limit. units: bytes. source: the kernel's cgroup-v2.rst, cgroup-v1/memory.rst
std::optional<std::uint64_t> find_group_memory(const std::filesystem::path& mount,
                                               const std::filesystem::path& own);

/// "3.1 GiB", "20.0 MiB".
std::string format_bytes(std::uint64_t bytes);

/// Runs `body` if about `bytes` are there. errors: InputError that names `what`, the bytes and what there is,
/// also where an allocation fails on the way.
void with_memory(const std::string& what, std::uint64_t bytes, const std::function<void()>& body);

}  // namespace equilux
