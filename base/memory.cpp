// /proc/meminfo and control groups.
#include "base/memory.h"

#include <algorithm>
#include <fstream>
#include <new>

#include "base/error.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

std::optional<std::uint64_t> read_number(const fs::path& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (file >> number) return number;
  return {};
}

// Of lines of a name, a number and perhaps more.
std::optional<std::uint64_t> read_entry(const fs::path& path, const std::string& wanted) {
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

// Where a version of control groups tells limit, use, and files that are kept in case they are read again:
// they count as used but give way.
struct GroupNames {
  const char* limit;
  const char* used;
  const char* files;
};
constexpr GroupNames kVersion2{"memory.max", "memory.current", "inactive_file"};
constexpr GroupNames kVersion1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};

// "max" where there is no limit, which is no number.
std::optional<std::uint64_t> find_left(const fs::path& group, const GroupNames& names) {
  const auto most = read_number(group / names.limit), used = read_number(group / names.used);
  if (!most || !used) return {};
  const std::uint64_t files = read_entry(group / "memory.stat", names.files).value_or(0);
  return *most - std::min(*most, *used - std::min(*used, files));
}

std::optional<std::uint64_t> find_least(std::optional<std::uint64_t> a, std::optional<std::uint64_t> b) {
  if (!a || !b) return a ? a : b;
  return std::min(*a, *b);
}

// Of a group, named from `root` on, and of those that it is part of. In a container the name may be that of
// the host, where nothing stands; the root then is the container's own.
std::optional<std::uint64_t> find_least_left(const fs::path& root, const fs::path& group,
                                             const GroupNames& names) {
  std::optional<std::uint64_t> least = find_left(root, names);
  fs::path path = root;
  for (const fs::path& part : group.relative_path())
    least = find_least(least, find_left(path /= part, names));
  return least;
}

bool names_memory(const std::string& controllers) {
  return ("," + controllers + ",").find(",memory,") != std::string::npos;
}

}  // namespace

std::string format_bytes(std::uint64_t bytes) {
  const double mebibytes = static_cast<double>(bytes) / (1 << 20);
  return mebibytes < 102.4 ? fmt::format("{:.1f} MiB", mebibytes)
                           : fmt::format("{:.1f} GiB", mebibytes / 1024);
}

// Lines of the file are NUMBER:CONTROLLERS:GROUP; version 2 names no controllers.
std::optional<std::uint64_t> find_group_memory(const fs::path& mount, const fs::path& own) {
  std::optional<std::uint64_t> least;
  std::ifstream file(own);
  std::string number, controllers, group;
  while (std::getline(file, number, ':') && std::getline(file, controllers, ':') &&
         std::getline(file, group)) {
    if (controllers.empty()) least = find_least(least, find_least_left(mount, group, kVersion2));
    if (names_memory(controllers))
      least = find_least(least, find_least_left(mount / "memory", group, kVersion1));
  }
  return least;
}

std::optional<std::uint64_t> find_available_memory() {
  return find_least(find_system_memory(), find_group_memory("/sys/fs/cgroup", "/proc/self/cgroup"));
}

void with_memory(const std::string& what, std::uint64_t bytes, const std::function<void()>& body) {
  const auto there = find_available_memory();
  const std::string expected = fmt::format("about {} of memory", format_bytes(bytes));
  if (there && *there < bytes) throw InputError(what, "", expected, format_bytes(*there));
  try {
    body();
  } catch (const std::bad_alloc&) {
    throw InputError(what, "", expected,
                     fmt::format("less: an allocation failed with {} free; is there a limit (ulimit -v)?",
                                 there ? format_bytes(*there) : "an unknown amount"));
  }
}

}  // namespace equilux
