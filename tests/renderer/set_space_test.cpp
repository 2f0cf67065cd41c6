// What a set takes of the disk, foreseen.
#include "renderer/set_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "renderer/jobs.h"
#include "renderer/set.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

// In blocks of 4 KiB. units: bytes
double sum_blocks(const fs::path& folder) {
  double bytes = 0;
  for (const auto& entry : fs::directory_iterator(folder))
    bytes += 4096 * std::ceil(static_cast<double>(entry.file_size()) / 4096);
  return bytes;
}

// 112 x 84 pixels of the café: 8 references, 88 VPL layers, all their pictures.
TEST(SetSpace, IsForeseenWithinAQuarter) {
  const test::TinyStudy tiny;
  Json json = tiny.load().source;
  json.set("image", parse_json(R"({"width":112,"height":84})", ""));
  save_text(tiny.path(), format_json(json));
  const StudyFolder folder{tiny.folder() / "set"};
  make_set({tiny.path(), folder.root});

  const Study study = tiny.load();
  const Scene scene = load_scene(study.scene_path);
  const Wanted wanted = enumerate_wanted(study, "*");
  const auto foreseen =
      static_cast<double>(estimate_set_bytes(study, estimate_worlds(study, scene, wanted), wanted));
  const double taken = sum_blocks(folder.layer_folder()) + sum_blocks(folder.picture_folder());
  EXPECT_NEAR(foreseen / taken, 1, 0.25) << foreseen << " foreseen, " << taken << " taken";
}

TEST(SetSpace, ThatADiskHasNotIsSaidWithBoth) {
  const test::Folder folder;
  check_space(folder.path(), 1);
  check_space(folder / "that is not there", std::uint64_t{1} << 60);
  EXPECT_THAT(message_of<InputError>([&] { check_space(folder.path(), std::uint64_t{1} << 60); }),
              AllOf(HasSubstr(folder.path().string()),
                    HasSubstr("expected about 1073741824.0 GiB free on its disk, got "),
                    HasSubstr("what is rendered already stays")));
}

}  // namespace
}  // namespace equilux
