// A stage of a room, of which an interrupted run left the bytes; the first byte chooses which. What is taken
// is the same when written and read again.
#include "renderer/room_format.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace equilux;

constexpr PixelSize kSize{4, 3};

template <typename T>
void read_stage(std::string_view bytes) {
  const auto stage = parse_stage<T>(bytes, kSize, "input");
  if (!stage) return;
  StageWriter once, twice;
  once.write(*stage);
  const std::string written = once.take();
  const auto again = parse_stage<T>(written, kSize, "written");
  EQ_CHECK(again.has_value());
  twice.write(*again);
  EQ_CHECK(twice.take() == written);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view text = as_text(bytes + 1, size - 1);
  if (bytes[0] % 3 == 0) {
    read_stage<TracedLayer>(text);
  } else if (bytes[0] % 3 == 1) {
    read_stage<RoomSets>(text);
  } else {
    read_stage<BackgroundPlan>(text);
  }
  return 0;
}
