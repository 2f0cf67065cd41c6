// A program loads no library that its use does not need.
#include <algorithm>
#include <array>
#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <string>
#include <vector>

namespace equilux {
namespace {

// Names in the dynamic section, by readelf of the compiler's binutils.
std::vector<std::string> list_needed(const std::string& program) {
  const std::string command = "readelf -d " EQUILUX_BIN_DIR "/" + program;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::vector<std::string> needed;
  std::array<char, 512> line{};
  while (pipe && std::fgets(line.data(), line.size(), pipe.get())) {
    const std::string text = line.data();
    const std::size_t start = text.find('[');
    if (text.find("(NEEDED)") != std::string::npos && start != std::string::npos)
      needed.push_back(text.substr(start + 1, text.find(']') - start - 1));
  }
  return needed;
}

void expect_none_of(const std::string& program, const std::vector<std::string>& beginnings) {
  const auto needed = list_needed(program);
  ASSERT_FALSE(needed.empty()) << program;
  for (const std::string& library : needed) {
    for (const std::string& beginning : beginnings)
      EXPECT_FALSE(library.starts_with(beginning)) << program << " loads " << library;
  }
}

const std::vector<std::string> kRendering{"libembree", "libtbb"},
    kWindow{"libglfw", "libimgui", "libGL", "libX11"}, kImages{"libOpenImageIO"};

TEST(Linkage, OfTheAnalysisHasNoRendererAndNoWindow) {
  expect_none_of("equilux-analyze", kRendering);
  expect_none_of("equilux-analyze", kWindow);
  expect_none_of("equilux-analyze", kImages);
}

TEST(Linkage, OfTheRendererHasNoWindowAndNoImageLibraryBeforeASheet) {
  expect_none_of("equilux-render", kWindow);
  expect_none_of("equilux-render", kImages);
  EXPECT_THAT(list_needed("equilux-render"), testing::Contains(testing::StartsWith("libembree")));
}

TEST(Linkage, OfTheSessionHasTheRendererOfItsWorkspaceAndNoImageLibrary) {
  expect_none_of("equilux-session", kImages);
#ifdef EQUILUX_WINDOW
  EXPECT_THAT(list_needed("equilux-session"), testing::Contains(testing::StartsWith("libembree")));
#else
  expect_none_of("equilux-session", kRendering);
#endif
}

}  // namespace
}  // namespace equilux
