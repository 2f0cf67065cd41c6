// windows.json and truth.json: one row a column of the study, no more, no fewer, each within the study's
// levels.
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "protocols/truth.h"
#include "protocols/windows.h"
#include "tests/support/failures.h"
#include "tests/support/json_edit.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::filesystem::path kProtocols = std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols";

Json read(const std::string& name) { return parse_json(load_text(kProtocols / name), name); }

class Rows : public testing::Test {
 protected:
  template <typename Load>
  std::string refusal_of(const Json& json, const Load& load) {
    const auto path = folder_.write("rows.json", format_json(json));
    const std::string message = message_of<InputError>([&] { load(path, study_); });
    EXPECT_THAT(message, StartsWith(path.string() + ": "));
    return message.substr(std::min(message.size(), path.string().size() + 2));
  }
  std::string window_refusal(const Json& json) { return refusal_of(json, load_windows); }
  std::string truth_refusal(const Json& json) { return refusal_of(json, load_truth); }

  const TempFolder folder_;
  const Json windows_ = read("pocket/windows.json");
  const Json truth_ = read("pocket/truth.json");
  Study study_ = load_study(kProtocols / "pocket.json");
};

TEST_F(Rows, OfWindowsAreReadWithTheirOrigin) {
  const Json edited = with(with(windows_, "/windows/0/origin", "by_eye"), "/windows/0/first", "C7");
  const Windows windows = load_windows(folder_.write("w", format_json(edited)), study_);
  const Window& window = windows.by_column.at(parse_column("G0-MS-ind-1k", "test"));
  EXPECT_EQ(window.first_level, 7);
  EXPECT_EQ(window.origin, WindowOrigin::kByEye);
  EXPECT_EQ(windows.digest, digest_json(edited));
}

TEST_F(Rows, OfWindowsKnowTheFourOrigins) {
  for (const char* origin : {"pilot", "predicted", "by_eye", "placeholder"}) {
    const auto path = folder_.write("w", format_json(with(windows_, "/windows/0/origin", origin)));
    EXPECT_EQ(format_origin(load_windows(path, study_).by_column.at(parse_column("G0-MS-ind-1k", "")).origin),
              origin);
  }
  EXPECT_THAT(window_refusal(with(windows_, "/windows/0/origin", "guess")),
              StartsWith("/windows/0/origin: "));
}

TEST_F(Rows, MayStandInAnyOrder) {
  Json::Array rows = windows_.at("windows").as_array();
  std::reverse(rows.begin(), rows.end());
  const auto path = folder_.write("w", format_json(with(windows_, "/windows", Json(rows))));
  EXPECT_EQ(load_windows(path, study_).by_column.at(parse_column("G0-MS-ind-1k", "test")).first_level, 7);
}

TEST_F(Rows, OfAColumnTwiceAreRefused) {
  EXPECT_THAT(window_refusal(with(windows_, "/windows/-", windows_.at("windows").at(std::size_t{0}))),
              AllOf(StartsWith("/windows/8/column: "), HasSubstr("G0-MS-ind-1k again")));
  EXPECT_THAT(truth_refusal(with(truth_, "/columns/-", truth_.at("columns").at(std::size_t{0}))),
              AllOf(StartsWith("/columns/8/column: "), HasSubstr("G0-MS-ind-1k again")));
}

TEST_F(Rows, OfAColumnThatTheStudyLacksAreRefused) {
  EXPECT_THAT(window_refusal(with(windows_, "/windows/2/column", "G1-MS-ind-1k")),
              AllOf(StartsWith("/windows/2/column: "), HasSubstr("a column of the study pocket")));
  EXPECT_THAT(truth_refusal(with(truth_, "/columns/2/column", "G1-MS-ind-1k")),
              StartsWith("/columns/2/column: "));
}

TEST_F(Rows, OfAMalformedColumnAreRefused) {
  for (const char* column : {"G0-MS-ind", "G0-MS-ind-1000", "", "G0-MS-ind-1k-C0"}) {
    EXPECT_THAT(window_refusal(with(windows_, "/windows/0/column", column)),
                StartsWith("/windows/0/column: "));
    EXPECT_THAT(truth_refusal(with(truth_, "/columns/0/column", column)), StartsWith("/columns/0/column: "));
  }
}

TEST_F(Rows, ThatAreMissingAreNamedByTheirColumn) {
  EXPECT_EQ(window_refusal(without(windows_, "/windows/3")),
            "/windows: expected a row for G0-GS-ind-100k, got none");
  EXPECT_EQ(truth_refusal(without(truth_, "/columns/3")),
            "/columns: expected a row for G0-GS-ind-100k, got none");
}

TEST_F(Rows, OfLevelsThatTheStudyLacksAreRefused) {
  study_.clamp_levels = {0, 1, 2, 3, 4, 5, 6};
  EXPECT_THAT(window_refusal(windows_),
              AllOf(StartsWith("/windows/0/first: "), HasSubstr("4 adjacent"), HasSubstr("C7")));
  study_.clamp_levels = {0, 1, 2, 3, 4, 6, 7, 8, 9, 10};
  EXPECT_THAT(window_refusal(windows_), HasSubstr("C5, which the study does not have"));
}

TEST_F(Rows, OfAWindowThatRunsBeyondC10AreRefused) {
  for (const char* first : {"C8", "C10", "C11", "c4"})
    EXPECT_THAT(window_refusal(with(windows_, "/windows/0/first", first)), StartsWith("/windows/0/first: "));
}

TEST_F(Rows, WithMembersMissingAddedOrOfAnotherVersionAreRefused) {
  EXPECT_THAT(window_refusal(without(windows_, "/windows/1/first")),
              StartsWith("/windows/1: expected a member"));
  EXPECT_THAT(window_refusal(with(windows_, "/windows/1/last", "C9")),
              StartsWith("/windows/1: expected only"));
  EXPECT_THAT(window_refusal(with(windows_, "/schema_version", 2)), StartsWith("/schema_version: "));
  EXPECT_THAT(window_refusal(truth_), StartsWith("/"));
  EXPECT_THAT(truth_refusal(without(truth_, "/columns/1/material_same_to")),
              StartsWith("/columns/1: expected a member"));
  EXPECT_THAT(truth_refusal(with(truth_, "/schema_version", 2)), StartsWith("/schema_version: "));
  EXPECT_THAT(truth_refusal(with(truth_, "/lapse_rate", 1.5)), StartsWith("/lapse_rate: "));
  EXPECT_THAT(truth_refusal(with(truth_, "/side_bias", -0.1)), StartsWith("/side_bias: "));
  EXPECT_THAT(truth_refusal(with(truth_, "/columns/0/artifact_free_from", "C11")),
              StartsWith("/columns/0/artifact_free_from: "));
  EXPECT_THROW(load_windows(folder_ / "missing", study_), InputError);
  EXPECT_THROW(load_truth(folder_.path(), study_), InputError);
}

TEST_F(Rows, OfATruthThatIsNeverReachedMeanEveryLevel) {
  const Json edited =
      with(with(truth_, "/columns/0/artifact_free_from", "never"), "/columns/0/material_same_to", "never");
  const Truth truth = load_truth(folder_.write("t", format_json(edited)), study_);
  const PlantedColumn& planted = truth.by_column.at(parse_column("G0-MS-ind-1k", "test"));
  EXPECT_EQ(planted.artifact_free_from, 11);
  EXPECT_EQ(planted.material_same_to, -1);
  EXPECT_EQ(truth.lapse_rate, 0.02);
  EXPECT_EQ(truth.side_bias, 0.5);
}

}  // namespace
}  // namespace equilux
