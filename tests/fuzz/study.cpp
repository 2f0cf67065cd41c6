// A study; its windows and truth, where the input has them after it, each after a line of "---".
#include "protocols/study.h"

#include <array>

#include "protocols/truth.h"
#include "protocols/windows.h"
#include "tests/fuzz/fuzz.h"

namespace {

// Up to three texts; what is not there is empty.
std::array<std::string_view, 3> split(std::string_view text) {
  constexpr std::string_view kLine = "\n---\n";
  std::array<std::string_view, 3> parts;
  for (std::string_view& part : parts) {
    const std::size_t end = std::min(text.find(kLine), text.size());
    part = text.substr(0, end);
    text.remove_prefix(std::min(end + kLine.size(), text.size()));
  }
  return parts;
}

void enumerate_all(const equilux::Study& study) {
  using namespace equilux;
  const std::size_t columns = enumerate_columns(study).size();
  EQ_CHECK(enumerate_conditions(study).size() == columns * study.clamp_levels.size() * kViewCount, columns);
  EQ_CHECK(enumerate_references(study).size() >= enumerate_families(study).size(), columns);
  for (const Condition& condition : enumerate_conditions(study)) {
    const std::string key = format_key(condition);
    EQ_CHECK(parse_condition(key, "key") == condition, key);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace equilux;
  const auto parts = split(as_text(bytes, size));
  const auto path = fuzz_folder().write("study.json", parts[0]);
  // What studies of the corpus extend.
  [[maybe_unused]] static const auto base = fuzz_folder().write(
      "base.json", R"({"schema": "equilux-study", "seed": 5, "scene": "scene.json", "blocks": []})");
  expect_read_or_refused("", [&] {
    const Study study = load_study(path);
    enumerate_all(study);
    expect_read_or_refused("windows.json",
                           [&] { load_windows(fuzz_folder().write("windows.json", parts[1]), study); });
    expect_read_or_refused("truth.json",
                           [&] { load_truth(fuzz_folder().write("truth.json", parts[2]), study); });
  });
  return 0;
}
