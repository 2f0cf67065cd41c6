// What programs leave beside a study's data and read again; the first byte chooses between timing.json,
// report-files.json, export.json and a table of texts.
#include "analysis/report_folder.h"
#include "experiment/export_log.h"
#include "experiment/texts.h"
#include "renderer/timing.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace equilux;
namespace fs = std::filesystem;

void read_timing(const fs::path& folder) {
  const std::optional<double> speed = find_speed({folder});
  EQ_CHECK(!speed || *speed > 0);
}

// Nothing of the folder is of a report that it lists, but by a digest that an input cannot know.
void read_report_list(const fs::path& folder) {
  const auto stranger = fuzz_folder().write("report/stranger.txt", "kept");
  save_report({}, folder);
  EQ_CHECK(read_bytes(stranger) == "kept");
}

void read_export_record(const fs::path& folder) { check_can_export(folder, true); }

void read_texts(const fs::path& folder) {
  const Texts texts = load_texts("xx", folder);
  for (const auto& [name, text] : texts.all()) EQ_CHECK(!texts.fill(name, {{"a", "{a}"}}).empty(), name);
}

struct Reader {
  const char *folder, *name;
  void (*read)(const fs::path& folder);
};

constexpr Reader kReaders[] = {{"timing", "timing.json", read_timing},
                               {"report", kReportList, read_report_list},
                               {"export", kExportRecord, read_export_record},
                               {"texts", "texts-xx.json", read_texts}};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const Reader& reader = kReaders[bytes[0] % std::size(kReaders)];
  const auto path =
      fuzz_folder().write((fs::path(reader.folder) / reader.name).string(), as_text(bytes + 1, size - 1));
  expect_read_or_refused(path.parent_path().string(), [&] { reader.read(path.parent_path()); });
  return 0;
}
