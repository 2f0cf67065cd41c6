// Any bytes as a PNG picture.
#include "stimuli/png_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  const auto path = fuzz_folder().write("input.png", as_text(bytes, size));
  expect_read_or_refused(path.filename().string(), [&] {
    const LdrImage image = load_png(path);
    if (image.values.size() > 1 << 20) return;
    EQ_CHECK(load_png(fuzz_folder().write("again.png", encode_png(image))) == image, image.width);
  });
  return 0;
}
