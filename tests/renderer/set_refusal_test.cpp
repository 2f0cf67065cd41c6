// A run that is refused leaves a set's folder as it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "renderer/room_stages.h"
#include "renderer/set.h"
#include "tests/renderer/rendered_set.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

class RefusedSet : public test::RenderedSet {
 protected:
  // This study with one member changed, in a file of its own beside it.
  fs::path edit(const std::string& member, Json value) const {
    Json json = study_.load().source;
    json.set(member, std::move(value));
    const fs::path path = study_.folder() / "edited.json";
    save_text(path, format_json(json));
    return path;
  }
  // The scene with a wider or narrower picture: layers are other ones, and the study file says the same.
  fs::path edit_scene() const {
    Json scene = parse_json(load_text(study_.load().scene_path), "scene"), camera = scene.at("camera");
    camera.set("vertical_fov_degrees", 50);
    scene.set("camera", camera);
    save_text(study_.folder() / "scene.json", format_json(scene));
    return edit("scene", "scene.json");
  }

  void expect_refused(const SetParams& params, const std::string& why) const {
    fs::remove(folder_.truth());  // a run that begins copies it
    const auto before = test::digest_products(folder_.root);
    EXPECT_THAT(message_of<InputError>([&] { make_set(params); }), HasSubstr(why));
    EXPECT_EQ(test::digest_products(folder_.root), before) << why;
  }
};

TEST_F(RefusedSet, WhoseLayersWouldChangeUnderSessionsIsAsItWas) {
  const fs::path edited = edit_scene();
  make_set({edited, folder_.root, "G0-MS-ind-ref-v0"});
  save_text(folder_.responses(), "a session's log stands here");
  save_text(study_.folder() / "scene.json", load_text(study_.load().scene_path));
  expect_refused({edited, folder_.root}, "another G0-MS-ind-ref-v0.background");
}

TEST_F(RefusedSet, WithADamagedRecordIsAsItWas) {
  const fs::path edited = edit("seed", 2);
  for (const fs::path& record : {folder_.layers(), folder_.manifest(), folder_.timing()}) {
    const std::string whole = load_text(record);
    save_text(record, "{");
    expect_refused({edited, folder_.root}, record.filename());
    save_text(record, whole);
  }
}

TEST_F(RefusedSet, WithoutUsableWindowsTruthOrProtocolIsAsItWas) {
  for (const char* member : {"windows", "session"}) {
    save_text(study_.folder() / "none.json", "{}");
    const fs::path edited = edit(member, "none.json");
    const fs::path target = folder_.root / (std::string(member) + ".json");
    const std::string whole = load_text(target);
    fs::remove(target);
    expect_refused({edited, folder_.root}, "none.json");
    save_text(target, whole);
  }
}

TEST_F(RefusedSet, ThatIsGatheredForAnotherVersionOfItsStudyIsAsItWas) {
  SetParams params{edit("seed", 2), folder_.root};
  params.render = false;
  expect_refused(params, "that of another, or of an older version");
}

TEST_F(RefusedSet, WhoseFoldersLeadElsewhereIsAsItWas) {
  for (const char* name : {"layers", "pictures", "rooms", "jobs"}) {
    const fs::path part = folder_.root / name, elsewhere = study_.folder() / (std::string("other-") + name);
    if (fs::exists(part)) fs::rename(part, elsewhere);
    fs::create_directories(elsewhere);
    fs::create_directory_symlink(elsewhere, part);
    if (name == std::string("pictures")) fs::remove(elsewhere / "G0-MS-ind-100-C4-v0.png");
    const auto before = test::digest_products(elsewhere);
    expect_refused({study_.path(), folder_.root},
                   std::string(name) + ": expected a folder in the study folder");
    EXPECT_THAT(message_of<InputError>([&] { tonemap_set(folder_.root); }), HasSubstr("a symbolic link"));
    EXPECT_EQ(test::digest_products(elsewhere), before);
    fs::remove(part);
    fs::rename(elsewhere, part);
  }
}

TEST_F(RefusedSet, RemovesNoStagesElsewhere) {
  const fs::path elsewhere = study_.folder() / "elsewhere", room = folder_.rooms() / "G0-ind-v0";
  make_folder(elsewhere);
  make_folder(folder_.rooms());
  save_text(elsewhere / "plan.stage", "somebody's");
  fs::create_directory_symlink(elsewhere, room);
  EXPECT_THAT(message_of<InputError>([&] {
                RoomStages(room, {}, {24, 18}).remove();
              }),
              HasSubstr("G0-ind-v0: expected a folder in the study folder, got a symbolic link"));
  EXPECT_TRUE(fs::exists(elsewhere / "plan.stage"));
}

}  // namespace
}  // namespace equilux
