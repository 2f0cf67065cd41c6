// layers.json and the study folder: round trip, and what is refused.
#include "stimuli/layers.h"

#include <gtest/gtest.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "stimuli/study_folder.h"
#include "tests/support/failures.h"
#include "tests/support/json_edit.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

Layers make_layers() {
  Layers layers{"pocket", digest_text("study"), 7, {}};
  for (const std::string name : {"G0-MS-ind-1k-C0-v0", "G0-MS-ind-ref-v0.background"})
    layers.by_name[name] = {"layers/" + name + ".exr", digest_text(name), digest_text("from"), 0};
  layers.by_name["G0-MS-ind-1k-C0-v0"].vpl_count = 1013;
  Json reference;
  reference.set("method", "path").set("paths", 2000);
  layers.by_name["G0-MS-ind-ref-v0.background"].reference = std::move(reference);
  return layers;
}

class LayersFile : public testing::Test {
 protected:
  LayersFile() {
    save_layers(make_layers(), folder_ / "saved.json");
    json_ = parse_json(load_text(folder_ / "saved.json"), "saved.json");
  }
  std::string refusal_of(const Json& json) {
    const auto path = folder_.write("layers.json", format_json(json));
    const std::string message = message_of<InputError>([&] { load_layers(path); });
    EXPECT_THAT(message, StartsWith(path.string() + ": "));
    return message.substr(std::min(message.size(), path.string().size() + 2));
  }
  const TempFolder folder_;
  Json json_;
};

TEST_F(LayersFile, RoundTrips) {
  const Layers saved = make_layers(), loaded = load_layers(folder_ / "saved.json");
  EXPECT_EQ(loaded.study_name, saved.study_name);
  EXPECT_EQ(loaded.study_digest, saved.study_digest);
  EXPECT_EQ(loaded.seed, saved.seed);
  ASSERT_EQ(loaded.by_name.size(), saved.by_name.size());
  for (const auto& [name, layer] : saved.by_name) {
    const LayerRecord& back = loaded.by_name.at(name);
    EXPECT_EQ(back.file, layer.file);
    EXPECT_EQ(back.digest, layer.digest);
    EXPECT_EQ(back.made_from, layer.made_from);
    EXPECT_EQ(back.vpl_count, layer.vpl_count);
    EXPECT_EQ(back.reference.is_null(), layer.reference.is_null());
  }
}

TEST_F(LayersFile, NamesLayersByTheirReference) {
  const Family family{{"G1", "MR", Illumination::kIndirect}, 0};
  EXPECT_EQ(layer_name(family, "background"), "G1-MR-ind-ref-v0.background");
}

TEST_F(LayersFile, WithoutAnyOneOfItsMembersNamesIt) {
  for (const auto& [name, value] : json_.as_object())
    EXPECT_EQ(refusal_of(without(json_, "/" + name)), "/: expected a member \"" + name + "\", got none");
}

TEST_F(LayersFile, IsRefusedForWhatItMayNotSay) {
  EXPECT_EQ(refusal_of(with(json_, "/schema_version", 2)), "/schema_version: expected 1, got 2");
  EXPECT_THAT(refusal_of(with(json_, "/layers/0/digest", "abc")), StartsWith("/layers/0/digest: "));
  EXPECT_THAT(refusal_of(with(json_, "/layers/0/vpl_count", 0)), StartsWith("/layers/0/vpl_count: "));
  EXPECT_THAT(refusal_of(with(json_, "/layers/1/reference/method", "guess")),
              StartsWith("/layers/1/reference/method: "));
  EXPECT_THAT(refusal_of(with(json_, "/layers/-", json_.at("layers").at(std::size_t{0}))),
              AllOf(StartsWith("/layers/2/name: "), HasSubstr("again")));
}

TEST_F(LayersFile, WithAPathThatLeavesTheFolderIsRefused) {
  for (const char* file : {"../x.exr", "layers/../x.exr", "/layers/x.exr", "layers/a/x.exr", "layers/x.png",
                           "x.exr", "layers/x.exr\n", "layers/x y.exr"})
    EXPECT_THAT(refusal_of(with(json_, "/layers/0/file", file)), StartsWith("/layers/0/file: ")) << file;
}

TEST_F(LayersFile, ThatCannotBeReadOrWrittenIsNamed) {
  EXPECT_THROW(load_layers(folder_ / "missing.json"), InputError);
  EXPECT_THROW(load_layers(folder_.path()), InputError);
  EXPECT_THROW(save_layers(make_layers(), folder_ / "missing/l.json"), StoreError);
}

// Blanks take the place of rows, which would take seconds to read.
TEST_F(LayersFile, MayBeLargerThanOtherFiles) {
  const auto path = folder_.write("l.json", format_json(json_) + std::string(std::size_t{80} << 20, ' '));
  EXPECT_EQ(load_layers(path).by_name.size(), 2u);
}

TEST(StudyFolders, OpenWithTheWindowsAndTruthOfTheirOwn) {
  const TempFolder folder;
  std::filesystem::copy_file(std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols/pocket.json",
                             folder / "study.json");
  const Study study = load_folder_study({folder.path()});
  EXPECT_EQ(study.name, "pocket");
  EXPECT_EQ(study.windows_path, folder / "windows.json");
  EXPECT_EQ(study.truth_path, folder / "truth.json");
  EXPECT_EQ(StudyFolder{folder.path()}.selection(SubjectKind::kPlanted), folder / "selection-planted.json");
}

TEST(StudyFolders, ThatAreNoneAreNamed) {
  const TempFolder folder;
  EXPECT_THAT(message_of<InputError>([&] { load_folder_study({folder.path()}); }),
              AllOf(StartsWith(folder.path().string()), HasSubstr("a folder without study.json")));
  EXPECT_THAT(message_of<InputError>([&] { load_folder_study({folder / "none"}); }),
              HasSubstr("nothing of that name"));
  EXPECT_THAT(message_of<InputError>([&] { load_folder_study({folder.write("study.json", "{}")}); }),
              HasSubstr("got a file"));
}

TEST(StudyFolders, WhoseStudyExtendsAnotherAreRefused) {
  const TempFolder folder;
  const auto base = std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols/pocket.json";
  for (const Json& extends : {Json(base.string()), Json("study.json"), Json("missing.json"), Json(3)}) {
    folder.write("study.json", format_json(Json().set("extends", extends)));
    EXPECT_EQ(message_of<InputError>([&] { load_folder_study({folder.path()}); }),
              fmt::format("{}: /extends: expected the whole study, as `equilux-render set` writes it, got {}",
                          (folder / "study.json").string(), describe_json(extends)));
  }
  folder.write("study.json", format_json(load_study(base).source));
  EXPECT_NO_THROW(load_folder_study({folder.path()}));
}

}  // namespace
}  // namespace equilux
