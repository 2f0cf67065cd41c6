// selection-<kind>.json against the pocket study.
#include "stimuli/selection.h"

#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  // With a digest that a file of the corpus can have, whatever becomes of the study.
  static const Study study = [] {
    Study pocket = load_study(EQUILUX_SOURCE_DIR "/protocols/pocket.json");
    pocket.digest = std::string(64, 'a');
    return pocket;
  }();
  const auto path = fuzz_folder().write("selection-person.json", as_text(bytes, size));
  expect_read_or_refused(path.filename().string(), [&] {
    const Selection selection = load_selection(path, study);
    enumerate_selected_cells(selection, study);
    save_selection(selection, path);
    EQ_CHECK(digest_selection(load_selection(path, study)) == digest_selection(selection));
  });
  return 0;
}
