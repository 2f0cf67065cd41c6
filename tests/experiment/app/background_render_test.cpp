// Rendering in a thread beside the window: its states, and that it can be begun, cancelled and begun again.
#include "experiment/app/background_render.h"

#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "renderer/set.h"
#include "stimuli/layers.h"
#include "stimuli/study_folder.h"
#include "tests/renderer/tiny_study.h"

namespace equilux {
namespace {

// As a window does that draws 50 times a second.
RenderState wait_for_end(BackgroundRender& render) {
  for (;;) {
    const RenderState state = render.poll();
    if (!is_active(state)) return state;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

TEST(BackgroundRender, MakesWhatMakeSetMakes) {
  const test::TinyStudy study;
  BackgroundRender render;
  EXPECT_EQ(render.poll(), RenderState::kIdle);
  render.start(study.path(), study.folder() / "beside");
  EXPECT_EQ(render.poll(), RenderState::kRunning);
  EXPECT_EQ(wait_for_end(render), RenderState::kDone);
  EXPECT_THAT(render.line(), testing::MatchesRegex("([0-9]+) pictures, [0-9]+ of them made now"));
  make_set({study.path(), study.folder() / "whole"});
  EXPECT_EQ(test::digest_products(study.folder() / "beside"),
            test::digest_products(study.folder() / "whole"));
}

TEST(BackgroundRender, SaysWhyItFailedAndCanBeBegunAgain) {
  const test::TinyStudy study;
  BackgroundRender render;
  render.start(study.folder() / "none.json", study.folder() / "set");
  EXPECT_EQ(wait_for_end(render), RenderState::kFailed);
  EXPECT_THAT(render.line(), testing::HasSubstr("none.json"));
  render.start(study.path(), study.folder() / "set");
  render.pause();
  EXPECT_EQ(render.poll(), RenderState::kPaused);
  render.resume();
  EXPECT_EQ(wait_for_end(render), RenderState::kDone);
}

// A reference whose record says that it is far from its path-traced check.
TEST(BackgroundRender, TellsWhatIsBeyondItsLimit) {
  const test::TinyStudy study;
  const StudyFolder folder{study.folder() / "set"};
  make_set({study.path(), folder.root});
  Layers layers = load_layers(folder.layers());
  layers.by_name.at("G0-MS-ind-ref-v0.indirect")
      .reference.set("check", parse_json(R"([{"region": "contact band", "pixels": 9, "mean": 1, "z": 7.1,
      "standard_error": 0.1, "path_traced": 1, "path_traced_error": 0.1}])",
                                         "check"));
  save_layers(layers, folder.layers());
  BackgroundRender render;
  render.start(study.path(), folder.root);
  EXPECT_EQ(wait_for_end(render), RenderState::kDone);
  EXPECT_THAT(render.line(),
              testing::HasSubstr("made now; BEYOND ITS LIMIT: G0-MS-ind-ref-v0.indirect: region "
                                 "contact band differs"));
}

TEST(BackgroundRender, WhenCancelledAndAtOnceWantedAgainBeginsAfterItsEnd) {
  const test::TinyStudy study;
  BackgroundRender render;
  render.start(study.path(), study.folder() / "set");
  render.pause();
  render.cancel();
  EXPECT_EQ(render.poll(), RenderState::kCancelling);
  EXPECT_EQ(wait_for_end(render), RenderState::kCancelled);
  render.start(study.path(), study.folder() / "set");
  render.cancel();
  render.start(study.path(), study.folder() / "set");
  EXPECT_EQ(wait_for_end(render), RenderState::kDone);
}

TEST(BackgroundRender, IsCancelledAtTheEndOfItsLifeEvenWhenPaused) {
  const test::TinyStudy study;
  {
    BackgroundRender render;
    render.start(study.path(), study.folder() / "set");
    render.pause();
  }
  make_set({study.path(), study.folder() / "set"});  // its lock is free
}

}  // namespace
}  // namespace equilux
