// How long a subject waits from an answer to the next pair: the main study's artifact session, answered at
// once by a planted subject, in the window. Its pictures are of its size and as hard to decode as rendered
// ones.
#include <filesystem>
#include <fmt/format.h>
#include <thread>

#include "base/error.h"
#include "base/random.h"
#include "tests/e2e/child_process.h"
#include "tests/e2e/x_display.h"
#include "tests/experiment/fake_study.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr int kWidth = 560, kHeight = 420;
constexpr std::size_t kPictures = 24;  // which stand under all names by turns
constexpr const char* kProtocol = R"({
  "schema": "equilux-session", "schema_version": 1,
  "familiarisation": {"objects": false, "examples": 0, "practice_trials": 0},
  "breaks": {"every_trials": 100000}
})";

// A ramp with a grain of some steps: a PNG of it is as large as one of the café.
LdrImage make_grainy_picture(std::uint64_t number) {
  LdrImage image(kWidth, kHeight);
  RandomStream random(number, "grain", 0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto shade = static_cast<std::uint32_t>(60 + (x + y) % 128) + random.next_below(6);
      const std::size_t pixel = static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x);
      for (std::size_t c = 0; c < 3; ++c)
        image.values[3 * pixel + c] = static_cast<std::uint8_t>(shade + 8 * c + random.next_below(3));
    }
  }
  return image;
}

StudyFolder make_study(const fs::path& root) {
  const StudyFolder folder = make_fake_study(root, "paper", 4, 3);
  save_text(folder.session(), kProtocol);
  std::vector<fs::path> sources;
  std::vector<std::string> digests;
  for (std::size_t i = 0; i < kPictures; ++i) {
    sources.push_back(root / fmt::format("source-{}.png", i));
    save_png(make_grainy_picture(i), sources.back());
    digests.push_back(digest_file(sources.back()));
  }
  fmt::print("{} pictures of {} x {}, each {:.0f} kB or so\n", kPictures, kWidth, kHeight,
             1e-3 * static_cast<double>(fs::file_size(sources[0])));
  Manifest manifest = load_manifest(folder.manifest());
  manifest.width = kWidth;
  manifest.height = kHeight;
  std::size_t next = 0;
  for (auto& [key, record] : manifest.pictures) {
    const std::size_t source = next++ % kPictures;
    fs::remove(folder.root / record.file);
    fs::create_hard_link(sources[source], folder.root / record.file);
    record.digest = digests[source];
  }
  save_manifest(manifest, folder.manifest());
  return folder;
}

int run() {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_study(temporary.path() / "study");
  const XDisplay display(1920, 1200);
  ChildProcess app({EQUILUX_BIN_DIR "/equilux-session", "run", folder.root.string(), "--experiment",
                    "artifact", "--planted", "1", "--pace", "0"},
                   {{"DISPLAY", display.name()}, {"LIBGL_ALWAYS_SOFTWARE", "1"}});
  while (app.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::optional<int> code = app.wait();
  fmt::print("{}", app.read_output());
  return code.value_or(1);
}

}  // namespace
}  // namespace equilux

int main() {
  try {
    return equilux::run();
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_onsets: {}\n", error.what());
    return 1;
  }
}
