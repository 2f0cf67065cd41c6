// Any bytes as an EXR picture.
#include <cmath>

#include "stimuli/exr_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  const auto path = fuzz_folder().write("input.exr", as_text(bytes, size));
  expect_read_or_refused(path.filename().string(), [&] {
    const HdrImage image = load_exr(path).image;
    for (float value : image.values) EQ_CHECK(std::isfinite(value), value);
  });
  return 0;
}
