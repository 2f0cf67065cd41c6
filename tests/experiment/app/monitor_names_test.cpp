// Names of monitors that are alike, and of colour profiles whole and damaged.
#include "experiment/app/monitor_names.h"

#include <cstdint>
#include <gtest/gtest.h>

namespace equilux {
namespace {

TEST(MonitorNames, OfTheSameKindAreNumbered) {
  EXPECT_EQ(label_monitors({"EIZO", "DELL", "EIZO", "EIZO"}),
            (std::vector<std::string>{"EIZO", "DELL", "EIZO#2", "EIZO#3"}));
  EXPECT_TRUE(label_monitors({}).empty());
}

std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
  return bytes;
}

// A header of 128 bytes, one other tag, and this one.
std::string make_profile(const std::string& tag) {
  const std::uint32_t first = 132 + 2 * 12;
  return std::string(128, '\1') + big_endian(2) + "wtpt" + big_endian(first) + big_endian(4) + "desc" +
         big_endian(first + 4) + big_endian(static_cast<std::uint32_t>(tag.size())) + "XYZ " + tag;
}

std::string make_mluc() {
  const std::string text(
      "\0s\0R\0G\0B\0 \0v\0"
      "4",
      14);
  return "mluc" + big_endian(0) + big_endian(1) + big_endian(12) + "enUS" + big_endian(14) + big_endian(28) +
         text;
}

TEST(ProfileName, IsTheDescriptionOfBothVersions) {
  EXPECT_EQ(find_profile_name(make_profile(make_mluc())), "sRGB v4") << "without its language";
  EXPECT_EQ(
      find_profile_name(make_profile("desc" + big_endian(0) + big_endian(5) + std::string("sRGB\0more", 9))),
      "sRGB");
  EXPECT_EQ(find_profile_name(make_profile("text" + big_endian(0) + "sRGB")), "");
}

TEST(ProfileName, OfDamagedBytesIsEmptyOrShorterAndNeverReadsOutside) {
  const std::string whole = make_profile(make_mluc());
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_EQ(find_profile_name(std::string_view(whole).substr(0, size)), "") << size;
  for (std::size_t i = 128; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = '\377';
    EXPECT_LE(find_profile_name(damaged).size(), 100u) << i;
  }
}

}  // namespace
}  // namespace equilux
