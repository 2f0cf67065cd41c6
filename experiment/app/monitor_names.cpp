// Names made unique, and a tag of an ICC file read.
#include "experiment/app/monitor_names.h"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <map>

namespace equilux {
namespace {

constexpr std::size_t kHeaderBytes = 132;  // with the number of tags
constexpr std::size_t kTagBytes = 12;
constexpr std::size_t kMostLetters = 100;

// Big-endian; 0 where the bytes end before.
std::uint32_t read_number(std::string_view bytes, std::size_t at) {
  if (at > bytes.size() || bytes.size() - at < 4) return 0;
  std::uint32_t value = 0;
  for (const char byte : bytes.substr(at, 4)) value = value << 8 | static_cast<unsigned char>(byte);
  return value;
}

// Empty where it would leave the bytes.
std::string_view take(std::string_view bytes, std::size_t from, std::size_t size) {
  return from > bytes.size() || size > bytes.size() - from ? std::string_view() : bytes.substr(from, size);
}

// UTF-16's high bytes of ASCII are 0, which is not printable.
std::string keep_printable(std::string_view bytes) {
  std::string text;
  std::copy_if(bytes.begin(), bytes.end(), std::back_inserter(text),
               [](char letter) { return letter >= ' ' && letter <= '~'; });
  return text.substr(0, kMostLetters);
}

std::string read_description(std::string_view tag) {
  if (tag.starts_with("mluc")) return keep_printable(take(tag, read_number(tag, 24), read_number(tag, 20)));
  return tag.starts_with("desc") ? keep_printable(take(tag, 12, read_number(tag, 8))) : "";
}

}  // namespace

std::vector<std::string> label_monitors(const std::vector<std::string>& names) {
  std::map<std::string, int> counts;
  std::vector<std::string> labels;
  for (const std::string& name : names) {
    const int count = ++counts[name];
    labels.push_back(count == 1 ? name : fmt::format("{}#{}", name, count));
  }
  return labels;
}

std::string find_profile_name(std::string_view profile) {
  if (profile.size() < kHeaderBytes) return "";
  const std::size_t tags =
      std::min<std::size_t>(read_number(profile, 128), (profile.size() - kHeaderBytes) / kTagBytes);
  for (std::size_t i = 0; i < tags; ++i) {
    const std::size_t tag = kHeaderBytes + kTagBytes * i;
    if (profile.substr(tag, 4) == "desc")
      return read_description(take(profile, read_number(profile, tag + 4), read_number(profile, tag + 8)));
  }
  return "";
}

}  // namespace equilux
