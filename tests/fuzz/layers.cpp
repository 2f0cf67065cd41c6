// layers.json: what is read stays in its folder and is the same when saved and read again.
#include "stimuli/layers.h"

#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  const auto path = fuzz_folder().write("layers.json", as_text(bytes, size));
  expect_read_or_refused(path.filename().string(), [&] {
    const Layers layers = load_layers(path);
    for (const auto& [name, layer] : layers.by_name)
      EQ_CHECK(std::filesystem::path(layer.file).parent_path() == "layers", layer.file);
    save_layers(layers, path);
    EQ_CHECK(load_layers(path).by_name.size() == layers.by_name.size(), layers.by_name.size());
  });
  return 0;
}
