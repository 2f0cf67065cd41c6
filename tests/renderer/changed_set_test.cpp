// A set that is made anew is marked until it is whole, and not begun where there are sessions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/picture_store.h"
#include "renderer/set.h"
#include "stimuli/change_mark.h"
#include "tests/renderer/rendered_set.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class ChangedSet : public test::RenderedSet {
 protected:
  bool is_marked() const { return !find_change_mark(folder_).empty(); }
  std::string make(const fs::path& study, const std::string& only = "*") const {
    try {
      make_set({study, folder_.root, only});
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  // A run that ends in the middle of its work.
  void stop_at(const fs::path& file) const {
    fs::remove(file);
    make_folder(file);
  }
};

TEST_F(ChangedSet, IsMarkedUntilItIsWhole) {
  const test::TinyStudy edited(study_.folder(), 2);
  const fs::path layer = folder_.root / "layers/G0-GS-ind-100-C4-v0.exr";
  stop_at(layer);
  EXPECT_THAT(make(edited.path()), HasSubstr("another kind"));
  EXPECT_TRUE(is_marked());
  fs::remove(layer);
  const SetSummary part = make_set({edited.path(), folder_.root, "G0-MS-ind-ref-v0"});
  EXPECT_THAT(part.warnings, Contains(HasSubstr("changing.txt: pictures are being made anew")));
  EXPECT_THAT(find(), Contains(HasSubstr("changing.txt")));
  tonemap_set(folder_.root, "G0-MS-ind-ref-v0");
  EXPECT_TRUE(is_marked()) << "layers of two studies";
  EXPECT_EQ(make(edited.path()), "");
  EXPECT_FALSE(is_marked());
  EXPECT_THAT(find(), IsEmpty());
}

TEST_F(ChangedSet, IsMarkedBeforeALayerOfTheSameStudyIsReplaced) {
  Layers layers = load_layers(folder_.layers());
  layers.by_name.at("G0-GS-ind-100-C4-v0").made_from = digest_text("another scene");
  save_layers(layers, folder_.layers());
  const fs::path layer = folder_.root / "layers/G0-GS-ind-100-C4-v0.exr";
  stop_at(layer);
  EXPECT_NE(make(study_.path()), "");
  EXPECT_TRUE(is_marked());
}

TEST_F(ChangedSet, IsMarkedWhileToneMappingReplacesPictures) {
  change_manifest([](Manifest& manifest) {
    manifest.pictures.at("G0-MS-ind-100-C4-v0").made_from = digest_text("another");
    manifest.pictures.at("G0-MS-ind-100-C4-v0").digest = digest_text("another");
  });
  const fs::path picture = folder_.root / "pictures/G0-MS-ind-100-C4-v0.png";
  stop_at(picture);
  EXPECT_THROW(tonemap_set(folder_.root, "*-C4-v0"), StoreError);
  EXPECT_TRUE(is_marked());
  remove_change_mark(folder_);
  fs::remove(picture);
  tonemap_set(folder_.root, "*-C4-v0");
  EXPECT_FALSE(is_marked()) << "all that was replaced is whole";
}

TEST_F(ChangedSet, ThatOnlyLacksSomethingIsNotMarked) {
  for (const char* file : {"layers/G0-GS-ind-100-C4-v0.exr", "pictures/G0-MS-ind-100-C4-v0.png"}) {
    stop_at(folder_.root / file);
    EXPECT_NE(make(study_.path()), "");
    EXPECT_FALSE(is_marked()) << "sessions may go on: nothing that was shown changes";
    fs::remove(folder_.root / file);
  }
}

// Sessions that began after the folder was looked at, and before it was marked.
TEST_F(ChangedSet, LooksForSessionsOnceItIsMarked) {
  begin_change(folder_, "another picture");
  EXPECT_TRUE(is_marked());
  save_text(folder_.responses(), "a session's log stands here");
  EXPECT_THAT(message_of<InputError>([&] { begin_change(folder_, "another picture"); }),
              HasSubstr("got another picture; render into a new folder"));
  EXPECT_TRUE(is_marked()) << "what an earlier run replaced is still to be made whole";
  remove_change_mark(folder_);
  EXPECT_THROW(begin_change(folder_, "another picture"), InputError);
  EXPECT_FALSE(is_marked());
}

}  // namespace
}  // namespace equilux
