// selection-<kind>.json: round trip, and that it belongs to one study.
#include "stimuli/selection.h"

#include <gtest/gtest.h>

#include "base/digest.h"
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

const std::filesystem::path kProtocols = std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols";

Selection make_selection(const Study& study) {
  Selection selection{SubjectKind::kPlanted, "paper", study.digest, digest_text("answers"), {}};
  for (const Column& column : enumerate_columns(study))
    selection.columns.push_back({column, "cut", 5, {5, 7, 9, 10}});
  selection.columns[1] = {selection.columns[1].column, "none", std::nullopt, {}};
  return selection;
}

class SelectionFile : public testing::Test {
 protected:
  SelectionFile() {
    save_selection(make_selection(study_), folder_ / "saved.json");
    json_ = parse_json(load_text(folder_ / "saved.json"), "saved.json");
  }
  std::string refusal_of(const Json& json) {
    const auto path = folder_.write("selection.json", format_json(json));
    const std::string message = message_of<InputError>([&] { load_selection(path, study_); });
    EXPECT_THAT(message, StartsWith(path.string() + ": "));
    return message.substr(std::min(message.size(), path.string().size() + 2));
  }
  const TempFolder folder_;
  Study study_ = load_study(kProtocols / "pocket.json");
  Json json_;
};

TEST_F(SelectionFile, RoundTrips) {
  const Selection saved = make_selection(study_), loaded = load_selection(folder_ / "saved.json", study_);
  EXPECT_EQ(loaded.kind, SubjectKind::kPlanted);
  EXPECT_EQ(loaded.rule, "paper");
  EXPECT_EQ(loaded.answers_digest, saved.answers_digest);
  EXPECT_EQ(digest_selection(loaded), digest_selection(saved));
  ASSERT_EQ(loaded.columns.size(), saved.columns.size());
  EXPECT_EQ(loaded.columns[0].levels, (std::vector<int>{5, 7, 9, 10}));
  EXPECT_EQ(loaded.columns[0].artifact_cut, 5);
  EXPECT_EQ(loaded.columns[1].status, "none");
  EXPECT_FALSE(loaded.columns[1].artifact_cut.has_value());
}

TEST_F(SelectionFile, LeavesTheCellsOfItsLevels) {
  const auto cells = enumerate_selected_cells(make_selection(study_), study_);
  EXPECT_EQ(cells.size(), 7u * 4);
  EXPECT_EQ(format_key(cells[1]), "G0-MS-ind-1k-C7");
  study_.normalise = true;
  EXPECT_EQ(format_key(enumerate_selected_cells(make_selection(study_), study_)[1]), "G0-MS-ind-1k-C7n");
}

TEST_F(SelectionFile, HasADigestThatLeavesTheProducerOut) {
  const auto path = folder_.write("other.json", format_json(with(json_, "/producer_version", "9.9.9")));
  EXPECT_EQ(digest_selection(load_selection(path, study_)), digest_selection(make_selection(study_)));
  Selection other = make_selection(study_);
  other.rule = "isotonic";
  EXPECT_NE(digest_selection(other), digest_selection(make_selection(study_)));
}

TEST_F(SelectionFile, OfAnotherStudyIsRefused) {
  EXPECT_THAT(refusal_of(with(json_, "/study_digest", digest_text("other"))),
              AllOf(StartsWith("/study_digest: "), HasSubstr(study_.digest)));
}

TEST_F(SelectionFile, WithoutAnyOneOfItsMembersNamesIt) {
  for (const auto& [name, value] : json_.as_object())
    EXPECT_EQ(refusal_of(without(json_, "/" + name)), "/: expected a member \"" + name + "\", got none");
}

TEST_F(SelectionFile, IsRefusedForWhatItMayNotSay) {
  EXPECT_EQ(refusal_of(with(json_, "/schema_version", 2)), "/schema_version: expected 1, got 2");
  EXPECT_THAT(refusal_of(with(json_, "/kind", "robot")), StartsWith("/kind: "));
  EXPECT_THAT(refusal_of(with(json_, "/rule", "mean")), StartsWith("/rule: "));
  EXPECT_THAT(refusal_of(with(json_, "/answers_digest", "x")), StartsWith("/answers_digest: "));
  EXPECT_THAT(refusal_of(with(json_, "/columns/0/status", "odd")), StartsWith("/columns/0/status: "));
  EXPECT_THAT(refusal_of(with(json_, "/columns/0/artifact_cut", "C11")),
              StartsWith("/columns/0/artifact_cut: "));
  EXPECT_THAT(refusal_of(with(json_, "/columns/0/levels/1", "C5")), StartsWith("/columns/0/levels: "));
  EXPECT_THAT(refusal_of(with(json_, "/columns/0/levels/1", "C99")), StartsWith("/columns/0/levels/1: "));
}

// Where artifacts are seen, nobody is asked about the material.
TEST_F(SelectionFile, WithALevelUnderTheArtifactCutIsRefused) {
  EXPECT_THAT(refusal_of(with(json_, "/columns/0/levels/0", "C4")),
              AllOf(StartsWith("/columns/0/levels: "), HasSubstr("levels from the artifact cut C5 on")));
}

TEST_F(SelectionFile, CoversTheStudysColumnsExactly) {
  EXPECT_THAT(refusal_of(with(json_, "/columns/-", json_.at("columns").at(std::size_t{0}))),
              AllOf(StartsWith("/columns/8/column: "), HasSubstr("again")));
  EXPECT_THAT(refusal_of(without(json_, "/columns/0")), HasSubstr("a row for G0-MS-ind-1k"));
  EXPECT_THAT(refusal_of(with(json_, "/columns/0/column", "G3-MS-ind-1k")),
              StartsWith("/columns/0/column: "));
}

TEST_F(SelectionFile, WithALevelThatTheStudyLacksIsRefused) {
  study_.clamp_levels = {0, 1, 2, 3, 4, 5, 6, 8, 9, 10};
  EXPECT_THAT(refusal_of(json_), AllOf(StartsWith("/columns/0/levels: "), HasSubstr("C7")));
}

TEST_F(SelectionFile, ThatCannotBeReadOrWrittenIsNamed) {
  EXPECT_THROW(load_selection(folder_ / "missing.json", study_), InputError);
  EXPECT_THROW(save_selection(make_selection(study_), folder_ / "missing/s.json"), StoreError);
}

}  // namespace
}  // namespace equilux
