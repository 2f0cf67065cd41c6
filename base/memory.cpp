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

std::optional<std::uint64_t> find_system_memory() {
  std::ifstream file("/proc/meminfo");
  std::string name, unit;
  for (std::uint64_t kibibytes = 0; file >> name >> kibibytes; std::getline(file, unit)) {
    if (name == "MemAvailable:") return kibibytes * 1024;
  }
  return {};
}

// "max" where there is no limit, which is no number.
std::optional<std::uint64_t> find_group_memory() {
  const auto most = read_number("/sys/fs/cgroup/memory.max"),
             used = read_number("/sys/fs/cgroup/memory.current");
  if (!most || !used) return {};
  return *most - std::min(*most, *used);
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
