// The counts of the four studies, which must come out of their factors; and their default windows and truths.
#include <gtest/gtest.h>
#include <set>

#include "protocols/study.h"
#include "protocols/truth.h"
#include "protocols/windows.h"

namespace equilux {
namespace {

Study load(const std::string& name) {
  return load_study(std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols" / (name + ".json"));
}

struct Counts {
  std::size_t columns, pictures_of_a_view, references_of_a_view, artifact_trials;
  bool operator==(const Counts&) const = default;
};

std::ostream& operator<<(std::ostream& out, const Counts& counts) {
  return out << counts.columns << " columns, " << counts.pictures_of_a_view << " pictures a view, "
             << counts.references_of_a_view << " references a view, " << counts.artifact_trials << " trials";
}

// Counted a view by its key, so that views of unlike size would show.
Counts count(const Study& study, int view) {
  Counts counts{enumerate_columns(study).size(), 0, 0, 0};
  for (const Condition& condition : enumerate_conditions(study))
    counts.pictures_of_a_view += condition.view == view;
  for (const Family& family : enumerate_families(study)) counts.references_of_a_view += family.view == view;
  counts.artifact_trials = counts.columns * kWindowLevels;
  return counts;
}

template <typename T>
bool all_distinct(const std::vector<T>& values) {
  return std::set<T>(values.begin(), values.end()).size() == values.size();
}

class EveryStudy : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Studies, EveryStudy,
                         testing::Values("pocket", "paper", "validation", "normalisation"));

TEST(Counts, OfThePaper) {
  const Study study = load("paper");
  for (int view : {0, 1}) EXPECT_EQ(count(study, view), (Counts{120, 1320, 40, 480}));
  EXPECT_EQ(enumerate_conditions(study).size(), 2640u);
  EXPECT_EQ(enumerate_cells(study).size(), 1320u);
  EXPECT_EQ(enumerate_families(study).size(), 80u);
  EXPECT_EQ(enumerate_references(study).size(), 80u) << "every geometry has other materials of its own";
}

TEST(Counts, OfTheValidation) {
  const Study study = load("validation");
  for (int view : {0, 1}) EXPECT_EQ(count(study, view), (Counts{42, 462, 16, 168}));
  // G0..G3 have LG alone, so GS and BR of each are rendered too.
  EXPECT_EQ(enumerate_references(study).size(), 2u * (16 + 4 * 2));
}

TEST(Counts, OfTheNormalisation) {
  const Study study = load("normalisation");
  for (int view : {0, 1}) EXPECT_EQ(count(study, view), (Counts{12, 132, 4, 48}));
  EXPECT_EQ(enumerate_conditions(study).size(), 264u);
  for (const Condition& condition : enumerate_conditions(study)) {
    EXPECT_TRUE(condition.cell.normalised);
    EXPECT_EQ(condition.cell.column.object.illumination, Illumination::kIndirect);
  }
}

TEST(Counts, OfThePocket) {
  const Study study = load("pocket");
  for (int view : {0, 1}) EXPECT_EQ(count(study, view), (Counts{8, 88, 4, 32}));
}

TEST_P(EveryStudy, HasItsNameAndNothingTwice) {
  const Study study = load(GetParam());
  EXPECT_EQ(study.name, GetParam());
  EXPECT_TRUE(all_distinct(enumerate_objects(study)));
  EXPECT_TRUE(all_distinct(enumerate_columns(study)));
  EXPECT_TRUE(all_distinct(enumerate_conditions(study)));
  EXPECT_TRUE(all_distinct(enumerate_references(study)));
}

TEST_P(EveryStudy, ReadsEveryKeyOfItsOwnBack) {
  const Study study = load(GetParam());
  for (const Condition& condition : enumerate_conditions(study)) {
    EXPECT_EQ(parse_condition(format_key(condition), "test"), condition);
    EXPECT_EQ(parse_cell(format_key(condition.cell), "test"), condition.cell);
    EXPECT_EQ(parse_column(format_key(condition.cell.column), "test"), condition.cell.column);
  }
  for (const Family& family : enumerate_references(study))
    EXPECT_EQ(parse_family(format_key(family), "test"), family);
}

TEST_P(EveryStudy, DrawsReferencesOfOtherMaterialsThatAreRendered) {
  const Study study = load(GetParam());
  const auto rendered = enumerate_references(study);
  for (const Object& object : enumerate_objects(study)) {
    const auto materials = enumerate_reference_materials(study, object);
    EXPECT_FALSE(materials.empty()) << format_key(object);
    EXPECT_TRUE(all_distinct(materials)) << format_key(object);
    for (const std::string& material : materials) {
      EXPECT_NE(material, object.material);
      for (int view : {0, 1}) {
        const Family family{{object.geometry, material, object.illumination}, view};
        EXPECT_NE(std::find(rendered.begin(), rendered.end(), family), rendered.end()) << format_key(family);
      }
    }
  }
}

TEST_P(EveryStudy, HasAWindowAndATruthForEachColumn) {
  const Study study = load(GetParam());
  const Windows windows = load_windows(study.windows_path, study);
  const Truth truth = load_truth(study.truth_path, study);
  EXPECT_EQ(windows.by_column.size(), enumerate_columns(study).size());
  EXPECT_EQ(truth.by_column.size(), enumerate_columns(study).size());
}

// The first tested level must show artifacts and the cut must be one that the window can find.
TEST_P(EveryStudy, HasADefaultTruthInsideItsWindows) {
  const Study study = load(GetParam());
  const Windows windows = load_windows(study.windows_path, study);
  for (const auto& [column, planted] : load_truth(study.truth_path, study).by_column) {
    const int first = windows.by_column.at(column).first_level;
    EXPECT_GT(planted.artifact_free_from, first) << format_key(column);
    EXPECT_LE(planted.artifact_free_from, first + kWindowLevels - 1) << format_key(column);
  }
}

TEST_P(EveryStudy, HasADefaultTruthWithGreenAndWithRed) {
  const Study study = load(GetParam());
  int green = 0, red = 0;
  for (const auto& [column, planted] : load_truth(study.truth_path, study).by_column)
    ++(planted.artifact_free_from <= planted.material_same_to ? green : red);
  EXPECT_GT(green, 0);
  EXPECT_GT(red, 0);
}

TEST(ReferenceMaterials, OfThePaperAreTheFourOthers) {
  const Study study = load("paper");
  for (const Object& object : enumerate_objects(study))
    EXPECT_EQ(enumerate_reference_materials(study, object).size(), 4u) << format_key(object);
}

}  // namespace
}  // namespace equilux
