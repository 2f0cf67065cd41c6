// manifest.json: what is read stays in its folder and is the same when saved and read again.
#include "stimuli/manifest.h"

#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  const auto path = fuzz_folder().write("manifest.json", as_text(bytes, size));
  expect_read_or_refused(path.filename().string(), [&] {
    const Manifest manifest = load_manifest(path);
    std::vector<std::string> keys;
    for (const auto& [key, picture] : manifest.pictures) {
      keys.push_back(key);
      EQ_CHECK(std::filesystem::path(picture.file).parent_path() == "pictures", picture.file);
    }
    save_manifest(manifest, path);
    EQ_CHECK(digest_pictures(load_manifest(path), keys, "saved") == digest_pictures(manifest, keys, "read"));
  });
  return 0;
}
