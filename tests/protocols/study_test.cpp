// Study files that are broken in one place each: the error names the file and the JSON pointer.
#include "protocols/study.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/failures.h"
#include "tests/support/json_edit.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class StudyFile : public testing::Test {
 protected:
  static Json original(const std::string& name) {
    const auto path = std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols" / (name + ".json");
    return load_study(path).source;
  }
  Study load(const Json& json) { return load_study(folder_.write("study.json", format_json(json))); }

  /// The error that loading gives, without the file's path, which it must begin with.
  std::string refusal_of_text(const std::string& text) {
    const auto path = folder_.write("study.json", text);
    const std::string message = message_of<InputError>([&] { load_study(path); });
    EXPECT_THAT(message, StartsWith(path.string() + ": "));
    return message.substr(std::min(message.size(), path.string().size() + 2));
  }
  std::string refusal_of(const Json& json) { return refusal_of_text(format_json(json)); }

  const TempFolder folder_;
  const Json pocket_ = original("pocket");
  const Json normalisation_ = original("normalisation");
};

TEST_F(StudyFile, IsReadInFull) {
  const Study study = load(pocket_);
  EXPECT_EQ(study.width, 280);
  EXPECT_EQ(study.height, 210);
  EXPECT_EQ(study.clamp_levels.size(), 11u);
  EXPECT_EQ(study.tone.exposure, Exposure::kBackground);
  EXPECT_EQ(study.view_mode, ViewMode::kReferenceTurned);
  EXPECT_FALSE(study.paths) << "as many as the noise target asks for";
  EXPECT_EQ(study.emission, Emission::kLambertian);
  EXPECT_EQ(study.subjects.at("artifact"), 12);
  EXPECT_EQ(study.subjects.at("material"), 14);
  EXPECT_EQ(study.windows_path, folder_ / "pocket/windows.json");
  EXPECT_EQ(study.scene_path, (folder_.path().parent_path() / "stimuli/scenes/cafe.json"));
  EXPECT_EQ(study.digest, digest_json(pocket_));
}

TEST_F(StudyFile, TakesCompensatedReferencesWhereANoiseTargetRules) {
  EXPECT_EQ(load(pocket_).reference, ReferenceMethod::kCompensated);
  EXPECT_EQ(load(without(pocket_, "/reference")).reference, ReferenceMethod::kCompensated);
  EXPECT_EQ(load(with(pocket_, "/reference", "path")).reference, ReferenceMethod::kPath);
  EXPECT_EQ(load(with(pocket_, "/reference", "compensated")).reference, ReferenceMethod::kCompensated);
  Json paths;
  paths.set("object_indirect", 16).set("object_direct", 16).set("background", 16);
  const Json fixed = with(without(pocket_, "/reference"), "/paths", paths);
  EXPECT_EQ(load(fixed).reference, ReferenceMethod::kPath);
  EXPECT_EQ(refusal_of(with(fixed, "/reference", "compensated")),
            "/reference: expected path, since /paths fixes their number, got compensated");
}

TEST_F(StudyFile, PlansByItsOwnToneMappingUnlessItSaysOtherwise) {
  EXPECT_EQ(load(pocket_).tone.operation, ToneOperator::kGlobal);
  Study study = load(with(with(pocket_, "/tone_operator", "local"), "/tone_key", .25));
  EXPECT_EQ(study.tone.operation, ToneOperator::kLocal);
  EXPECT_EQ(study.planned_tone.operation, ToneOperator::kLocal);
  EXPECT_EQ(study.planned_tone.key, .25);
  Json planned;
  planned.set("tone_key", .18).set("exposure", "whole");
  study = load(with(with(pocket_, "/tone_operator", "local"), "/planned_tone", planned));
  EXPECT_EQ(study.tone.exposure, Exposure::kBackground);
  EXPECT_EQ(study.planned_tone.operation, ToneOperator::kGlobal);
  EXPECT_EQ(study.planned_tone.exposure, Exposure::kWhole);
  EXPECT_EQ(refusal_of(with(pocket_, "/tone_operator", "filmic")).substr(0, 16), "/tone_operator: ");
  EXPECT_EQ(refusal_of(with(pocket_, "/planned_tone", planned.set("tone_key", 0))).substr(0, 23),
            "/planned_tone/tone_key:");
}

TEST_F(StudyFile, WithoutAnyOneOfItsMembersNamesTheMember) {
  Json blank = pocket_;
  for (const char* member : {"/description", "/normalise", "/reference", "/session"})
    blank = without(blank, member);
  ASSERT_NO_THROW(load(blank)) << "these four may be left out";
  for (const auto& [name, value] : blank.as_object())
    EXPECT_EQ(refusal_of(without(blank, "/" + name)), "/: expected a member \"" + name + "\", got none");
  std::map<std::string, Json> inner{{"/blocks/0", blank.at("blocks").at(std::size_t{0})}};
  for (const std::string name : {"image", "noise_target", "target", "subjects"})
    inner["/" + name] = blank.at(name);
  for (const auto& [place, object] : inner) {
    for (const auto& [name, value] : object.as_object())
      EXPECT_EQ(refusal_of(without(blank, place + "/" + name)),
                place + ": expected a member \"" + name + "\", got none");
  }
}

TEST_F(StudyFile, WithAMemberTooManyNamesIt) {
  for (const char* place : {"", "/image", "/noise_target", "/target", "/subjects", "/blocks/0"}) {
    EXPECT_THAT(refusal_of(with(pocket_, std::string(place) + "/extra", 1)),
                AllOf(StartsWith(*place ? std::string(place) + ": " : "/: "), HasSubstr("\"extra\"")));
  }
}

TEST_F(StudyFile, WithAWrongValueSaysWhereAndWhatIsExpected) {
  const std::tuple<const char*, Json, const char*> cases[] = {
      {"/schema", "equilux-scene", "\"equilux-study\""},
      {"/schema_version", 2, "expected 1, got 2"},
      {"/schema_version", "1", "expected 1"},
      {"/name", "a b", "string"},
      {"/name", "../x", "string"},
      {"/name", 7, "string"},
      {"/seed", -1, "a whole number from 0 to 9223372036854775807"},
      {"/seed", 1.5, "a whole number from 0 to 9223372036854775807"},
      {"/image/width", 0, "integer of at least 1"},
      {"/image/height", 20000, "at most 16384"},
      {"/subpixel_positions", 0, "integer"},
      {"/paths", parse_json(R"({"object_indirect": 1, "object_direct": 1})", ""), "a member \"background\""},
      {"/paths", 5, "object"},
      {"/reference", "photons", "one of path, compensated"},
      {"/emission", "half", "one of lambertian, full"},
      {"/noise_target/object_mean", 0, "number over 0"},
      {"/exposure", "middle", "one of background, whole"},
      {"/tone_key", 0, "number"},
      {"/normalise", "no", "boolean"},
      {"/certified", 1, "boolean"},
      {"/view_mode", "turned", "one of reference_turned, pair_turned"},
      {"/clamp_levels/3", "C11", "one of C0"},
      {"/clamp_levels/3", "C0", "without repetition"},
      {"/clamp_levels", Json(Json::Array{}), "array"},
      {"/target/degrees_wide", -16, "number"},
      {"/subjects/artifact", 0, "integer"},
      {"/blocks", Json(Json::Array{}), "array"},
      {"/blocks/0/geometries/1", "G 2", "a name of letters and digits"},
      {"/blocks/0/materials", Json(Json::Array{}), "array"},
      {"/blocks/0/materials/1", "MS", "without repetition"},
      {"/blocks/0/illuminations/0", "dim", "one of ind, dir"},
      {"/blocks/0/vpl_counts/0", "1x", "a VPL count"},
      {"/blocks/0/vpl_counts/0", 1000, "a VPL count"}};
  for (const auto& [place, value, expected] : cases) {
    const std::string message = refusal_of(with(pocket_, place, value));
    const std::string pointer = place;
    const bool on_list = std::string_view(expected) == "without repetition";
    EXPECT_THAT(message, StartsWith((on_list ? pointer.substr(0, pointer.rfind('/')) : pointer) + ": "))
        << message;
    EXPECT_THAT(message, HasSubstr(expected));
  }
}

TEST_F(StudyFile, WithAVplCountBeyondTheLimitSaysSo) {
  EXPECT_THAT(refusal_of(with(pocket_, "/blocks/0/vpl_counts/0", "2000M")),
              StartsWith("/blocks/0/vpl_counts"));
}

TEST_F(StudyFile, WithOverlappingBlocksNamesTheSecondAndTheColumn) {
  const Json twice = with(pocket_, "/blocks/-", pocket_.at("blocks").at(std::size_t{0}));
  EXPECT_EQ(refusal_of(twice), "/blocks/1: expected columns that no other block has, got G0-MS-ind-1k");
  const Json one_shared = with(with(twice, "/blocks/1/geometries", make_json({"G1", "G2"})),
                               "/blocks/1/vpl_counts", make_json({"100k", "5M"}));
  EXPECT_THAT(refusal_of(one_shared), AllOf(StartsWith("/blocks/1: "), HasSubstr("G2-MS-ind-100k")));
  EXPECT_NO_THROW(load(with(twice, "/blocks/1/geometries", make_json({"G1", "G3"}))));
}

TEST_F(StudyFile, WithOneCountInTwoSpellingsIsRefused) {
  EXPECT_THAT(refusal_of(with(pocket_, "/blocks/0/vpl_counts", make_json({"1k", "1000"}))),
              StartsWith("/blocks/0"));
}

// 64 x 64 x 2 x 32 in one block of a kilobyte.
TEST_F(StudyFile, OfTooManyColumnsIsRefusedBeforeTheyAreMade) {
  std::vector<std::string> tokens, counts;
  for (int i = 0; i < 64; ++i) tokens.push_back(fmt::format("X{}", i));
  for (int i = 1; i <= 32; ++i) counts.push_back(fmt::format("{}k", i));
  Json block;
  block.set("geometries", make_json(tokens)).set("materials", make_json(tokens));
  block.set("illuminations", make_json({"ind", "dir"})).set("vpl_counts", make_json(counts));
  EXPECT_EQ(refusal_of(with(pocket_, "/blocks/1", block)),
            "/blocks/1: expected at most 4000 columns in all, got 262152 up to this block");
}

TEST_F(StudyFile, OfAsManyColumnsAsAreAllowedIsReadAndEnumeratedAtOnce) {
  std::vector<std::string> geometries, materials;
  for (int i = 0; i < 50; ++i) geometries.push_back(fmt::format("X{}", i));
  for (int i = 0; i < 40; ++i) materials.push_back(fmt::format("Y{}", i));
  Json block;
  block.set("geometries", make_json(geometries)).set("materials", make_json(materials));
  block.set("illuminations", make_json({"ind", "dir"})).set("vpl_counts", make_json({"1k"}));
  const Study study = load(with(pocket_, "/blocks", Json(Json::Array{block})));
  EXPECT_EQ(enumerate_columns(study).size(), 4000u);
  EXPECT_EQ(enumerate_references(study).size(), 8000u) << "each material is a reference of the others";
}

// 64 x 2 objects a block, each with 64 other materials.
TEST_F(StudyFile, OfMoreReferencesThanLayersCanBeRecordedIsRefused) {
  std::vector<std::string> materials;
  for (int i = 0; i < 64; ++i) materials.push_back(fmt::format("Y{}", i));
  const auto block_of = [](const std::string& letter) {
    std::vector<std::string> geometries;
    for (int i = 0; i < 64; ++i) geometries.push_back(fmt::format("{}{}", letter, i));
    Json block;
    block.set("geometries", make_json(geometries)).set("materials", make_json({"MS"}));
    return block.set("illuminations", make_json({"ind", "dir"})).set("vpl_counts", make_json({"1k"}));
  };
  Json study = with(pocket_, "/blocks", Json(Json::Array{block_of("A")}));
  study.set("reference_materials", make_json(materials));
  EXPECT_EQ(enumerate_references(load(study)).size(), 64u * 2 * 65 * 2);
  EXPECT_EQ(refusal_of(with(study, "/blocks/-", block_of("B"))),
            "/reference_materials: expected at most 20000 references in all, got 33280");
}

TEST_F(StudyFile, WithoutAReferenceMaterialSaysForWhichObject) {
  EXPECT_THAT(
      refusal_of(without(normalisation_, "/reference_materials")),
      AllOf(StartsWith("/reference_materials: "), HasSubstr("other than MR"), HasSubstr("G0-MR-ind")));
  EXPECT_THAT(refusal_of(with(normalisation_, "/reference_materials", make_json({"MR"}))),
              StartsWith("/reference_materials: "));
}

TEST_F(StudyFile, DropsItsOwnMaterialFromTheReferenceMaterials) {
  const Study study = load(with(normalisation_, "/reference_materials", make_json({"MR", "GS"})));
  EXPECT_EQ(enumerate_reference_materials(study, enumerate_objects(study).front()),
            std::vector<std::string>{"GS"});
}

TEST_F(StudyFile, WithADuplicateMemberIsRefused) {
  std::string text = format_json(pocket_);
  text.insert(text.find("\"seed\""), "\"seed\": 2, ");
  EXPECT_THAT(refusal_of_text(text), StartsWith("/seed: "));
}

TEST_F(StudyFile, ThatIsNotJsonSaysLineAndColumn) {
  EXPECT_THAT(refusal_of_text("{\n\"schema\": x}"), StartsWith("line 2, column 11: "));
  EXPECT_THAT(refusal_of_text(""), StartsWith("line 1, column 1: "));
  EXPECT_THAT(refusal_of_text("[]"), StartsWith("/: expected object"));
}

TEST_F(StudyFile, ThatIsHugeIsRefusedBeforeItIsParsed) {
  const auto path = folder_.write("study.json", "{}");
  std::filesystem::resize_file(path, (std::uintmax_t{64} << 20) + 1);
  EXPECT_THAT(message_of<InputError>([&] { load_study(path); }),
              AllOf(StartsWith(path.string()), HasSubstr("at most 67108864 bytes")));
}

TEST_F(StudyFile, ThatIsMissingOrAFolderIsNamed) {
  EXPECT_THAT(message_of<InputError>([&] { load_study(folder_ / "none.json"); }), HasSubstr("none.json"));
  EXPECT_THAT(message_of<InputError>([&] { load_study(folder_.path()); }), HasSubstr("got a folder"));
}

TEST_F(StudyFile, ThatExtendsAnotherIsWhatItWouldBeInFull) {
  std::filesystem::create_directory(folder_ / "base");
  folder_.write("base/pocket.json", format_json(pocket_));
  const Json block = parse_json(
      R"({"geometries":["G1"],"materials":["MR"],"illuminations":["dir"],"vpl_counts":["5M"]})", "");
  Json extension;
  extension.set("extends", "base/pocket.json").set("name", "more").set("windows", "windows.json");
  extension.set("reference_materials", make_json({"GS"})).set("more_blocks", Json(Json::Array{block}));
  const Study study = load(extension);
  Json full = pocket_, blocks = pocket_.at("blocks");
  blocks.push(block);
  full.set("name", "more").set("windows", "windows.json").set("reference_materials", make_json({"GS"}));
  full.set("truth", "base/pocket/truth.json")
      .set("session", "base/pocket/session.json")
      .set("scene", "stimuli/scenes/cafe.json")
      .set("blocks", std::move(blocks));
  EXPECT_EQ(format_canonical_json(study.source), format_canonical_json(full));
  EXPECT_EQ(study.digest, digest_json(full));
  EXPECT_EQ(study.windows_path, folder_ / "windows.json");
  EXPECT_EQ(study.truth_path, folder_ / "base/pocket/truth.json");
  EXPECT_EQ(study.scene_path, folder_ / "stimuli/scenes/cafe.json");
  EXPECT_EQ(study.blocks.size(), pocket_.at("blocks").as_array().size() + 1);
}

TEST_F(StudyFile, ThatExtendsAnotherKeepsAbsoluteNamesAndNeedsNoFolderInItsOwn) {
  std::filesystem::create_directory(folder_ / "base");
  folder_.write("base/pocket.json", format_json(with(pocket_, "/scene", "/somewhere/scene.json")));
  folder_.write("study.json", format_json(Json().set("extends", "base/pocket.json")));
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  const Study study = load_study("study.json");
  std::filesystem::current_path(before);
  EXPECT_EQ(study.scene_path, "/somewhere/scene.json");
  EXPECT_EQ(study.truth_path, "base/pocket/truth.json");
}

TEST_F(StudyFile, ThatExtendsWhatItCannotSaysSo) {
  EXPECT_THAT(refusal_of(Json().set("extends", 3)),
              HasSubstr("/extends: expected the name of a study file, got 3"));
  EXPECT_THAT(refusal_of(Json().set("extends", "study.json")),
              HasSubstr("/extends: expected a chain of at most 8 studies, got a longer one"));
  folder_.write("study.json", format_json(Json().set("extends", "none.json")));
  EXPECT_THAT(message_of<InputError>([&] { load_study(folder_ / "study.json"); }), HasSubstr("none.json"));
  EXPECT_THAT(refusal_of(with(pocket_, "/more_blocks", pocket_.at("blocks"))), HasSubstr("more_blocks"));
  folder_.write("base.json", format_json(pocket_));
  Json again = Json().set("extends", "base.json").set("more_blocks", pocket_.at("blocks"));
  EXPECT_THAT(refusal_of(again), HasSubstr("/blocks/1: expected columns that no other block has"));
  EXPECT_THAT(refusal_of(again.set("more_blocks", 1)), HasSubstr("/more_blocks: expected an array"));
  EXPECT_THAT(refusal_of(Json().set("extends", "base.json").set("colour", 1)), HasSubstr("colour"));
}

TEST_F(StudyFile, GivesOneDigestWhateverTheOrderOfItsMembers) {
  EXPECT_EQ(load(reversed(pocket_)).digest, load(pocket_).digest);
  const Json swapped = with(pocket_, "/blocks/0/geometries", make_json({"G2", "G0"}));
  EXPECT_NE(load(swapped).digest, load(pocket_).digest) << "the order of an array counts";
  EXPECT_NE(load(with(pocket_, "/seed", 2)).digest, load(pocket_).digest);
}

TEST_F(StudyFile, GivesLevelsAndCountsInOrderHoweverTheyAreListed) {
  const Json mixed = with(with(pocket_, "/clamp_levels", make_json({"C10", "C0", "C4"})),
                          "/blocks/0/vpl_counts", make_json({"5M", "1k"}));
  const Study study = load(mixed);
  EXPECT_EQ(study.clamp_levels, (std::vector<int>{0, 4, 10}));
  EXPECT_EQ(study.blocks[0].vpl_counts, (std::vector<std::int64_t>{1000, 5000000}));
}

}  // namespace
}  // namespace equilux
