// Layers on disk: what a killed run left whole is never made again, what cannot be read is.
#include "renderer/layer_store.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "renderer/set.h"
#include "tests/renderer/tiny_study.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using test::digest_products;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kRecipe = digest_text("one"), kOther = digest_text("another");

// A study folder that layers are saved into.
class LayersOnDisk : public testing::Test {
 protected:
  LayersOnDisk() { fs::create_directories(root() / "layers"); }

  fs::path root() const { return study_.folder() / "set"; }
  LayerStore open() const { return {{root()}, study_.load()}; }
  static HdrImage make_image(float value) {
    HdrImage image(24, 18);
    for (float& one : image.values) one = value;
    return image;
  }
  // As a process that is killed before it has written layers.json.
  void save_without_record() const {
    LayerStore store = open();
    Json vpls;
    vpls.set("method", "plain sum").set("shadow_rays", 12);
    store.save("G0-MS-ind-100-C3-v0", kRecipe, make_image(1), {}, {7, vpls, {}});
    store.save("G0-MS-ind-ref-v0.direct", kOther, make_image(2), {});
  }

  test::TinyStudy study_;
};

TEST_F(LayersOnDisk, AreRecordedAsSoonAsTheyStand) {
  save_without_record();
  EXPECT_FALSE(path_exists(root() / "layers.json"));
  LayerStore store = open();
  EXPECT_TRUE(store.is_whole("G0-MS-ind-100-C3-v0", kRecipe));
  EXPECT_TRUE(store.is_whole("G0-MS-ind-ref-v0.direct", kOther));
  EXPECT_FALSE(store.is_whole("G0-MS-ind-ref-v0.direct", kRecipe));
  EXPECT_EQ(store.record("G0-MS-ind-100-C3-v0").vpl_count, 7);
  EXPECT_EQ(store.record("G0-MS-ind-100-C3-v0").vpls.at("shadow_rays").as_int(), 12);
  store.save("G0-MS-ind-ref-v0.indirect", kOther, make_image(3), {});
  EXPECT_EQ(open().records().size(), 3u) << "killed once more";
  store.save_record();
  EXPECT_EQ(load_layers(root() / "layers.json").by_name.size(), 3u);
  EXPECT_EQ(std::distance(fs::directory_iterator(root()), fs::directory_iterator()), 2)
      << "layers and layers.json alone";
}

// Of 100 layers in twenty groups every record is there.
TEST_F(LayersOnDisk, OfManyGroupsAreOnRecordWithoutWritingAllEachTime) {
  LayerStore store = open();
  const StudyFolder folder{root()};
  std::set<std::string> records;
  for (int layer = 0; layer < 100; ++layer) {
    store.save(fmt::format("G{}-MS-ind-ref-v0.direct", layer), kOther, make_image(1), {});
    if (layer % 5 != 4) continue;
    store.save_group();
    ASSERT_EQ(open().records().size(), static_cast<std::size_t>(layer) + 1);
    if (path_exists(folder.layers())) records.insert(digest_file(folder.layers()));
  }
  EXPECT_EQ(records.size(), 11u) << "after 5, 10, 15, 20, 30 ... 90";
  store.save_record();
  EXPECT_EQ(load_layers(folder.layers()).by_name.size(), 100u);
  EXPECT_FALSE(path_exists(folder.pending_layers()));
}

// What was recorded before its file was renamed, when a disk was full or the process killed, and anything.
TEST_F(LayersOnDisk, AreNotTakenForOthersThanTheirRecordsTellOf) {
  save_without_record();
  const auto pending = StudyFolder{root()}.pending_layers();
  const fs::path file = root() / "layers/G0-MS-ind-ref-v0.direct.exr";
  save_text(file, "old bytes");
  EXPECT_EQ(open().records().size(), 1u);
  fs::remove(file);
  EXPECT_EQ(open().records().size(), 1u);
  for (const char* text : {"", "{", "[]", R"({"schema":"equilux-layers"})"}) {
    save_text(pending, text);
    EXPECT_EQ(open().records().size(), 0u) << text;
  }
  fs::remove(pending);
  fs::create_directory(pending);
  EXPECT_EQ(open().records().size(), 0u);
}

// Full at 20,000 bytes, which layers.json comes to after some groups and no layer does.
TEST_F(LayersOnDisk, AreNotMadeAgainBySetAfterItWasStopped) {
  SetParams params{study_.path(), root()};
  {
    const FileSizeLimit full(20000);
    EXPECT_THAT(message_of<StoreError>([&] { make_set(params); }), HasSubstr("layers.json"));
  }
  std::map<fs::path, fs::file_time_type> before;
  for (const auto& entry : fs::directory_iterator(root() / "layers"))
    before[entry.path()] = entry.last_write_time();
  EXPECT_GT(before.size(), load_layers(root() / "layers.json").by_name.size());
  make_set(params);
  for (const auto& [path, time] : before) EXPECT_EQ(fs::last_write_time(path), time) << path;
  params.folder = study_.folder() / "whole";
  make_set(params);
  EXPECT_EQ(digest_products(root()), digest_products(params.folder));
}

// A file of which nothing can be read, as of a disk that fails: a process has nothing at address 0.
TEST_F(LayersOnDisk, AreMadeAnewWhereTheyCannotBeRead) {
  SetParams params{study_.path(), root(), "G0-MS-ind-ref-v0"};
  const std::size_t layers = make_set(params).layers_rendered;
  const auto before = digest_products(root());
  const fs::path broken = root() / "layers/G0-MS-ind-ref-v0.coverage.exr";
  fs::remove(broken);
  fs::create_symlink("/proc/self/mem", broken);
  const SetSummary again = make_set(params);
  EXPECT_EQ(again.layers_rendered, layers);
  EXPECT_THAT(again.warnings, ElementsAre(AllOf(HasSubstr(broken.string()), HasSubstr("Input/output error"),
                                                HasSubstr("the layer counts as missing"))));
  EXPECT_EQ(digest_products(root()), before);
}

}  // namespace
}  // namespace equilux
