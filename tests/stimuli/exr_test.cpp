// EXR files: exact round trips, foreign ones written by the library itself, and every way to fail.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <cmath>
#include <gtest/gtest.h>
#include <half.h>
#include <limits>

#include "base/error.h"
#include "base/random.h"
#include "stimuli/exr_file.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// Values of all magnitudes, denormal and negative ones among them.
HdrImage make_layer(int width, int height, int channels) {
  HdrImage image(width, height, channels);
  RandomStream random(3, "exr", 0);
  for (float& value : image.values)
    value = std::ldexp(random.next_float() - 0.5f, static_cast<int>(random.next_below(250)) - 135);
  image.values[0] = std::numeric_limits<float>::denorm_min();
  image.values.back() = std::numeric_limits<float>::max();
  return image;
}

// Files that others might write: any data window, any type, any channels; the value of a pixel is x + 100 y.
template <typename T>
void write_foreign(const std::filesystem::path& path, const Imath::Box2i& window,
                   const std::vector<const char*>& names, Imf::PixelType type) {
  Imf::Header header(Imath::Box2i({0, 0}, {99, 99}), window);
  const int width = window.max.x - window.min.x + 1, height = window.max.y - window.min.y + 1;
  std::vector<T> values;
  for (int y = window.min.y; y <= window.max.y; ++y) {
    for (int x = window.min.x; x <= window.max.x; ++x) values.push_back(T(static_cast<float>(x + 100 * y)));
  }
  Imf::FrameBuffer buffer;
  for (const char* name : names) {
    header.channels().insert(name, Imf::Channel(type));
    auto* base = reinterpret_cast<char*>(values.data() - window.min.x - window.min.y * width);
    buffer.insert(name, Imf::Slice(type, base, sizeof(T), sizeof(T) * static_cast<std::size_t>(width)));
  }
  Imf::OutputFile output(path.c_str(), header, 0);
  output.setFrameBuffer(buffer);
  output.writePixels(height);
}

// True for a StoreError. Nothing is printed under the limit, which would hold for a log, too.
bool fails_to_save(const HdrImage& image, const std::filesystem::path& path, std::uintmax_t limit_bytes) {
  const FileSizeLimit limit(limit_bytes);
  try {
    save_exr(image, {}, path);
  } catch (const StoreError&) {
    return true;
  }
  return false;
}

void expect_refused(const std::filesystem::path& path, const char* words = "") {
  EXPECT_THAT(message_of<InputError>([&] { load_exr(path); }),
              AllOf(StartsWith(path.string() + ": "), HasSubstr(words)));
}

TEST(Exr, RoundTripsEveryBitOfOneAndThreeChannelsWithItsMetadata) {
  const TempFolder folder;
  const ExrMetadata metadata{
      {"equilux:made_from", std::string(64, 'a')}, {"name", "G1-MR-ind-ref-v0"}, {"empty", ""}};
  for (int channels : {1, 3}) {
    for (const auto& [width, height] : {std::pair{1, 1}, {37, 23}, {5, 100}}) {
      const HdrImage image = make_layer(width, height, channels);
      save_exr(image, metadata, folder / "a.exr");
      const ExrFile file = load_exr(folder / "a.exr");
      EXPECT_EQ(file.image.width, width);
      EXPECT_EQ(file.image.height, height);
      EXPECT_EQ(file.image.channels, channels);
      EXPECT_EQ(file.image.values, image.values);
      for (const auto& [name, value] : metadata) EXPECT_EQ(file.metadata.at(name), value);
    }
  }
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(Exr, GivesTheSameBytesTwice) {
  const TempFolder folder;
  save_exr(make_layer(40, 30, 3), {{"a", "b"}}, folder / "a.exr");
  save_exr(make_layer(40, 30, 3), {{"a", "b"}}, folder / "b.exr");
  EXPECT_EQ(read_bytes(folder / "a.exr"), read_bytes(folder / "b.exr"));
}

TEST(Exr, WithADataWindowAwayFromTheOriginIsRead) {
  const TempFolder folder;
  for (const auto& origin : {Imath::V2i(10, 20), Imath::V2i(-7, -3)}) {
    write_foreign<float>(folder / "a.exr", {origin, origin + Imath::V2i(4, 2)}, {"R", "G", "B"}, Imf::FLOAT);
    const HdrImage image = load_exr(folder / "a.exr").image;
    ASSERT_EQ(image.width, 5);
    ASSERT_EQ(image.height, 3);
    EXPECT_EQ(image.pixel(0)[0], static_cast<float>(origin.x + 100 * origin.y));
    EXPECT_EQ(image.pixel(14)[2], static_cast<float>(origin.x + 4 + 100 * (origin.y + 2)));
  }
}

TEST(Exr, OfAnotherSizeThanIsAskedForIsRefused) {
  const TempFolder folder;
  save_exr(HdrImage(5, 3), {}, folder / "a.exr");
  EXPECT_EQ(load_exr(folder / "a.exr", PixelSize{5, 3}).image.width, 5);
  EXPECT_THAT(message_of<InputError>([&] {
                load_exr(folder / "a.exr", PixelSize{3, 5});
              }),
              HasSubstr("dataWindow: expected 3 x 5 pixels, got 5 x 3"));
}

TEST(Exr, OfHalfFloatsIsRead) {
  const TempFolder folder;
  write_foreign<half>(folder / "a.exr", {{0, 0}, {6, 4}}, {"R", "G", "B", "A"}, Imf::HALF);
  const HdrImage image = load_exr(folder / "a.exr").image;
  EXPECT_EQ(image.channels, 3);
  EXPECT_EQ(image.pixel(7 * 4 + 6)[1], 406);
}

TEST(Exr, OfOtherChannelsIsRefused) {
  const TempFolder folder;
  write_foreign<float>(folder / "a.exr", {{0, 0}, {6, 4}}, {"R", "G"}, Imf::FLOAT);
  expect_refused(folder / "a.exr", "channels: expected R, G, B, or Y");
}

TEST(Exr, TooWideIsRefusedWithItsSize) {
  const TempFolder folder;
  write_foreign<float>(folder / "a.exr", {{0, 0}, {16384, 0}}, {"Y"}, Imf::FLOAT);
  expect_refused(folder / "a.exr", "1 to 16384 pixels a side, got 16385 x 1");
}

TEST(Exr, WithAValueThatIsNotFiniteIsRefusedWithThePixelsPlace) {
  const TempFolder folder;
  for (float bad : {std::nanf(""), INFINITY, -INFINITY}) {
    std::vector<float> values(7 * 5, 1.0f);
    values[7 * 2 + 3] = bad;
    Imf::Header header(7, 5);
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    Imf::FrameBuffer buffer;
    buffer.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 28));
    {
      Imf::OutputFile output((folder / "a.exr").c_str(), header, 0);
      output.setFrameBuffer(buffer);
      output.writePixels(5);
    }
    expect_refused(folder / "a.exr", "pixel (3, 2): expected finite values");
  }
}

TEST(Exr, WithAValueThatIsNotFiniteIsOurBugToWrite) {
  const TempFolder folder;
  for (float bad : {std::nanf(""), INFINITY, -INFINITY}) {
    HdrImage image(3, 3, 1);
    image.values[4] = bad;
    EXPECT_THROW(save_exr(image, {}, folder / "a.exr"), CheckFailure);
  }
  EXPECT_EQ(folder.entry_count(), 0);
}

TEST(Exr, CutOffAnywhereIsRefused) {
  const TempFolder folder;
  save_exr(make_layer(64, 48, 3), {{"a", "b"}}, folder / "whole.exr");
  const std::string whole = read_bytes(folder / "whole.exr");
  for (int tenth = 0; tenth < 10; ++tenth)
    expect_refused(folder.write("a.exr", std::string_view(whole).substr(0, whole.size() * tenth / 10)));
  for (std::size_t missing : {1u, 10u, 200u})
    expect_refused(folder.write("a.exr", std::string_view(whole).substr(0, whole.size() - missing)));
}

// OpenEXR would take gigabytes for each before it reads a pixel.
TEST(Exr, WithAHeaderThatItsBytesCannotKeepIsRefusedBeforeMemoryIsTaken) {
  const std::string corpus = EQUILUX_SOURCE_DIR "/tests/fuzz/corpus/exr/";
  expect_refused(corpus + "declares-16384-squared",
                 "no more pixels than 335 bytes can hold, got 16384 x 16384");
  expect_refused(corpus + "string-of-2-gib",
                 "header: expected one that ends within 65536 bytes, got none in 335");
  expect_refused(corpus + "string-of-negative", "attributes with a size, got -1");
  expect_refused(corpus + "channels-of-another-size", "attributes of plain types, each of its size");
  expect_refused(corpus + "window-far", "a corner within 16777216 pixels of the origin");
  const TempFolder folder;
  save_exr(HdrImage(16384, 300, 3), {}, folder / "a.exr");
  EXPECT_EQ(load_exr(folder / "a.exr").image.values.size(), 16384u * 300 * 3)
      << "as small as a file of black can be";
}

TEST(Exr, InTilesOrPartsOrWithALossIsRefused) {
  const std::string corpus = EQUILUX_SOURCE_DIR "/tests/fuzz/corpus/exr/";
  expect_refused(corpus + "tiled-y",
                 "version: expected 2, of one part and in scan lines, got 2, with the flags 0x2");
  for (const char* name : {"pxr24-y", "b44-half", "b44a-half", "dwaa-rgb", "dwab-rgb"})
    expect_refused(corpus + name, "compression: expected one without loss: none, RLE, ZIPS, ZIP or PIZ");
  for (const char* name : {"none-y", "rle-y", "zips-y", "zip-y", "piz-y", "zip-rgb"})
    EXPECT_EQ(load_exr(corpus + name).image.values.at(0), .5f) << name;
}

TEST(Exr, ThatIsNoneOrMissingOrAFolderIsRefused) {
  const TempFolder folder;
  expect_refused(folder.write("a.exr", "a text that says it is a picture"), "a whole EXR file");
  expect_refused(folder.write("a.exr", ""));
  expect_refused(folder / "missing.exr");
  expect_refused(folder.path());
}

// The disk is full at every twentieth of the file, and a byte before its end.
TEST(Exr, ThatDoesNotFitOnTheDiskIsAStoreErrorAndLeavesNothing) {
  const TempFolder folder;
  for (const auto& [width, height] : {std::pair{8, 6}, {64, 48}, {200, 150}}) {
    const HdrImage image = make_layer(width, height, 3);
    save_exr(image, {}, folder / "whole.exr");
    const auto size = std::filesystem::file_size(folder / "whole.exr");
    std::filesystem::remove(folder / "whole.exr");
    std::vector<std::uintmax_t> limits{size - 1, size - 100};
    for (std::uintmax_t part = 0; part < 20; ++part) limits.push_back(size * part / 20);
    for (const auto bytes : limits) {
      EXPECT_TRUE(fails_to_save(image, folder / "a.exr", bytes)) << bytes << " of " << size;
      EXPECT_EQ(folder.entry_count(), 0) << bytes << " of " << size;
      std::filesystem::remove(folder / "a.exr");
    }
  }
}

TEST(Exr, IntoAMissingFolderIsAStoreErrorThatNamesThePath) {
  const TempFolder folder;
  const auto path = folder / "missing/a.exr";
  EXPECT_THAT(message_of<StoreError>([&] { save_exr(make_layer(4, 4, 3), {}, path); }),
              HasSubstr(path.string()));
}

}  // namespace
}  // namespace equilux
