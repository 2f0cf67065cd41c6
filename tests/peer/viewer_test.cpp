// A layer as a program sees it that knows nothing of this one: OpenImageIO's oiiotool.
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "renderer/set.h"
#include "stimuli/exr_file.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/shell.h"

namespace equilux {
namespace {
using testing::HasSubstr;

constexpr const char* kKey = "G0-MS-ind-100-C4-v1";

// The numbers of a line of its statistics, such as "Stats Avg: 0.1 0.2 0.3 (float)".
std::vector<double> read_statistics(const std::string& text, const std::string& name) {
  const std::string head = "Stats " + name + ":";
  const std::size_t at = text.find(head);
  if (at == std::string::npos) return {};
  std::istringstream line(text.substr(at + head.size()));
  std::vector<double> values;
  for (double value = 0; line >> value;) values.push_back(value);
  return values;
}

TEST(Viewer, SeesALayersNamesUnitsAndLight) {
  const test::TinyStudy study;
  const std::filesystem::path folder = study.folder() / "set";
  make_set({study.path(), folder, kKey});
  const std::filesystem::path file = folder / "layers" / (std::string(kKey) + ".exr");
  const test::CommandResult seen = test::run_shell("oiiotool --info -v --stats '" + file.string() + "'");
  ASSERT_EQ(seen.exit_code, 0) << seen.text;
  const ExrFile layer = load_exr(file);
  for (const auto& [name, value] : layer.metadata)
    EXPECT_THAT(seen.text, HasSubstr(fmt::format("{}: \"{}\"", name, value)));
  for (const char* line : {"channel list: R, G, B", "equilux_unit: \"W/(m^2 sr)\"", "NanCount: 0 0 0"})
    EXPECT_THAT(seen.text, HasSubstr(line));
  EXPECT_THAT(seen.text, HasSubstr(fmt::format("equilux_key: \"{}\"", kKey)));
  const auto mean = read_statistics(seen.text, "Avg"), most = read_statistics(seen.text, "Max");
  ASSERT_EQ(mean.size(), 3u) << seen.text;
  ASSERT_EQ(most.size(), 3u) << seen.text;
  const HdrImage& image = layer.image;
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0, largest = 0;
    for (std::size_t i = 0; i < image.pixel_count(); ++i) {
      sum += double{image.pixel(i)[c]};
      largest = std::max(largest, double{image.pixel(i)[c]});
    }
    EXPECT_GT(largest, 0);
    EXPECT_NEAR(mean[c], sum / static_cast<double>(image.pixel_count()), 1e-6);
    EXPECT_NEAR(most[c], largest, 1e-6);
  }
}

}  // namespace
}  // namespace equilux
