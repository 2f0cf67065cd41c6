// /proc/meminfo and the control group of version 2.
#include "base/memory.h"

#include <algorithm>
#include <fstream>
#include <new>

#include "base/error.h"

namespace equilux {
namespace {

std::optional<std::uint64_t> read_number(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (file >> number) return number;
  return {};
}

// Of lines of a name, a number and perhaps more.
std::optional<std::uint64_t> read_entry(const std::string& path, const std::string& wanted) {
  std::ifstream file(path);
  std::string name, rest;
  for (std::uint64_t number = 0; file >> name >> number; std::getline(file, rest)) {
    if (name == wanted) return number;
  }
  return {};
}

std::optional<std::uint64_t> find_system_memory() {
  const auto kibibytes = read_entry("/proc/meminfo", "MemAvailable:");
  if (!kibibytes) return {};
  return *kibibytes * 1024;
}

// "max" where there is no limit, which is no number. Files that are kept in case they are read again count as
// used but give way.
std::optional<std::uint64_t> find_group_memory() {
  const auto most = read_number("/sys/fs/cgroup/memory.max"),
             used = read_number("/sys/fs/cgroup/memory.current");
  if (!most || !used) return {};
  const std::uint64_t files = read_entry("/sys/fs/cgroup/memory.stat", "inactive_file").value_or(0);
  return *most - std::min(*most, *used - std::min(*used, files));
}

std::string format_gibibytes(std::uint64_t bytes) {
  return fmt::format("{:.1f} GiB", static_cast<double>(bytes) / (1 << 30));
}

}  // namespace

std::optional<std::uint64_t> find_available_memory() {
  const auto system = find_system_memory(), group = find_group_memory();
  if (!system) return group;
  return group ? std::min(*system, *group) : system;
}

void with_memory(const std::string& what, std::uint64_t bytes, const std::function<void()>& body) {
  const auto there = find_available_memory();
  const std::string expected = fmt::format("about {} of memory", format_gibibytes(bytes));
  if (there && *there < bytes) throw InputError(what, "", expected, format_gibibytes(*there));
  try {
    body();
  } catch (const std::bad_alloc&) {
    throw InputError(what, "", expected,
                     fmt::format("less: an allocation failed with {} free; is there a limit (ulimit -v)?",
                                 there ? format_gibibytes(*there) : "an unknown amount"));
  }
}

}  // namespace equilux
