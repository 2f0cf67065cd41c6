// PNG files: round trips, and every way in which one can be no PNG.
#include <cmath>
#include <gtest/gtest.h>

#include "base/error.h"
#include "stimuli/png_file.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

// Every byte value occurs, and no two rows are alike.
LdrImage make_picture(int width, int height) {
  LdrImage image(width, height);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = static_cast<std::uint8_t>(i * 37 + i / 251);
  return image;
}

void expect_refused(const std::filesystem::path& path, const char* words = "") {
  EXPECT_THAT(message_of<InputError>([&] { load_png(path); }),
              AllOf(StartsWith(path.string() + ": "), HasSubstr(words)));
}

TEST(Png, RoundTripsEveryByte) {
  const TempFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, {1, 300}, {300, 1}, {257, 33}}) {
    const LdrImage image = make_picture(width, height);
    save_png(image, folder / "a.png");
    EXPECT_EQ(load_png(folder / "a.png"), image) << width << " x " << height;
  }
  EXPECT_EQ(folder.entry_count(), 1);
}

TEST(Png, GivesTheSameBytesTwice) {
  const TempFolder folder;
  const LdrImage image = make_picture(64, 48);
  save_png(image, folder / "a.png");
  EXPECT_EQ(read_bytes(folder / "a.png"), encode_png(image));
  EXPECT_EQ(encode_png(image), encode_png(make_picture(64, 48)));
}

TEST(Png, DamagedAnywhereInItsPixelsIsRefused) {
  const TempFolder folder;
  const std::string whole = encode_png(make_picture(64, 48));
  for (std::size_t place : {whole.size() / 3, whole.size() / 2, whole.size() - 40}) {
    std::string damaged = whole;
    damaged[place] = static_cast<char>(damaged[place] ^ 0x40);
    expect_refused(folder.write("a.png", damaged));
  }
}

TEST(Png, CutOffAnywhereIsRefused) {
  const TempFolder folder;
  const std::string whole = encode_png(make_picture(64, 48));
  for (std::size_t length : {std::size_t{0}, std::size_t{4}, std::size_t{8}, std::size_t{20}, std::size_t{33},
                             std::size_t{60}, whole.size() / 2, whole.size() - 30})
    expect_refused(folder.write("a.png", std::string_view(whole).substr(0, length)));
}

TEST(Png, ThatIsNoneIsRefused) {
  const TempFolder folder;
  expect_refused(folder.write("a.png", "GIF89a, or a text that says it is a picture"), "a PNG file");
  expect_refused(folder.write("a.png", std::string(1000, '\0')));
}

TEST(Png, WithAHeaderOfTooManyPixelsIsRefusedWithBothNumbers) {
  const TempFolder folder;
  const LdrImage wide(20000, 1);
  expect_refused(folder.write("a.png", encode_png(wide)), "at most 16384 x 16384 pixels, got 20000 x 1");
}

// A header alone would cost 805 MB.
TEST(Png, ThatDeclaresMorePixelsThanItsBytesCanHoldIsRefusedBeforeMemoryIsTaken) {
  const TempFolder folder;
  const std::string path = EQUILUX_SOURCE_DIR "/tests/fuzz/corpus/png/declares-16384-squared";
  expect_refused(path, "expected the 16384 x 16384 pixels that it declares, got 66 bytes, too few for them");
  save_png(LdrImage(16384, 300), folder / "a.png");
  EXPECT_EQ(load_png(folder / "a.png"), LdrImage(16384, 300)) << "as small as a file of black can be";
}

TEST(Png, ThatIsMissingOrAFolderIsNamed) {
  const TempFolder folder;
  expect_refused(folder / "missing.png");
  expect_refused(folder.path(), "got a folder");
}

TEST(Png, ThatDoesNotFitOnTheDiskLeavesNothing) {
  const TempFolder folder;
  {
    const FileSizeLimit limit(500);
    EXPECT_THAT(message_of<StoreError>([&] { save_png(make_picture(64, 48), folder / "a.png"); }),
                HasSubstr("a.png"));
  }
  EXPECT_EQ(folder.entry_count(), 0);
  EXPECT_THROW(save_png(make_picture(2, 2), folder / "missing/a.png"), StoreError);
}

// A grey PNG of one pixel, 100, that claims a linear gamma: 255 (100/255)^(1/2.2) in sRGB.
TEST(Png, OfAnotherGammaIsConverted) {
  const unsigned char bytes[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
      0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
      0x00, 0x00, 0x04, 0x67, 0x41, 0x4d, 0x41, 0x00, 0x01, 0x86, 0xa0, 0x31, 0xe8, 0x96, 0x5f, 0x00, 0x00,
      0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x48, 0x01, 0x00, 0x00, 0x66, 0x00, 0x65, 0x7a,
      0xa0, 0xc6, 0x92, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  const TempFolder folder;
  const auto path = folder.write("a.png", {reinterpret_cast<const char*>(bytes), sizeof bytes});
  EXPECT_NEAR(load_png(path).values[0], 255 * std::pow(100 / 255.0, 1 / 2.2), 1);
}

}  // namespace
}  // namespace equilux
