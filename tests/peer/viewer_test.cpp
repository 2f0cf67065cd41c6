// A layer as a program sees it that knows nothing of this one: OpenImageIO's oiiotool.
#include <cmath>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sstream>

#include "base/error.h"
#include "renderer/set.h"
#include "stimuli/exr_file.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"
#include "tests/support/shell.h"
#include "tests/support/temp_folder.h"

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

// What a layer has beside its light no picture shows.
TEST(Viewer, WhoAddsAChannelToALayerMakesItNoneOfTheSet) {
  const TempFolder folder;
  const std::filesystem::path file = folder / "layer.exr";
  save_exr(HdrImage(4, 3), {}, file);
  load_exr(file, PixelSize{4, 3});
  const test::CommandResult made =
      test::run_shell(fmt::format("oiiotool '{0}' --ch R,G,B,A=0.5 -o '{0}' 2>&1", file.string()));
  ASSERT_EQ(made.exit_code, 0) << made.text;
  EXPECT_THAT(message_of<InputError>([&] {
                load_exr(file, PixelSize{4, 3});
              }),
              HasSubstr("layer.exr: channels: expected R, G, B, or Y, and no more: 3, got 4"));
  EXPECT_EQ(load_exr(file).image.channels, 3) << "of another program, whose size nobody knows";
}

}  // namespace
}  // namespace equilux
