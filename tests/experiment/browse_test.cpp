// The workspace's values.
#include "experiment/browse.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "experiment/open_session.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class BrowseTest : public ::testing::Test {
 protected:
  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path());
  Study study_ = load_folder_study(folder_);
  Column column_ = enumerate_columns(study_).at(0);
};

TEST_F(BrowseTest, TellsWhatASetHoldsAndLacks) {
  Manifest manifest = load_manifest(folder_.manifest());
  const auto look = [&](const std::optional<Manifest>& in) { return find_holding(study_, in, folder_.root); };
  EXPECT_EQ(look(manifest).there, 2 * 8 * 11 + 2 * 4);
  EXPECT_THAT(look(manifest).missing, IsEmpty());
  std::filesystem::remove(folder_.root / manifest.pictures.at("G0-MS-ind-1k-C2-v1").file);
  EXPECT_THAT(look(manifest).missing, ElementsAre("G0-MS-ind-1k-C2-v1"));
  manifest.pictures.erase("G0-MS-ind-1k-C3-v1");
  EXPECT_THAT(look(manifest).missing, ElementsAre("G0-MS-ind-1k-C2-v1", "G0-MS-ind-1k-C3-v1"));
  EXPECT_EQ(look(std::nullopt).missing.size(), 184u);
}

TEST_F(BrowseTest, CountsAnswersToEachCell) {
  const auto trials = make_fake_trials(2);
  const auto coverage = tally_coverage(
      {{1, 0, trials[0].cell, true}, {1, 0, trials[1].cell, false}, {2, 1, trials[0].cell, true}});
  EXPECT_EQ(coverage.at(trials[0].cell).right, 2);
  EXPECT_EQ(coverage.at(trials[0].cell).answered, 2);
  EXPECT_EQ(coverage.at(trials[1].cell).right, 0);
}

TEST_F(BrowseTest, AWindowMovesAsFarAsTheLevelsGo) {
  const auto first_of = [&](int steps) {
    return save_shifted_window(folder_, study_, column_, steps).by_column.at(column_).first_level;
  };
  const int before = load_windows(folder_.windows(), study_).by_column.at(column_).first_level;
  EXPECT_EQ(first_of(-1), before - 1);
  EXPECT_EQ(first_of(1), before);
  EXPECT_EQ(first_of(100), 11 - kWindowLevels);
  EXPECT_EQ(first_of(-100), 0);
  EXPECT_EQ(load_windows(folder_.windows(), study_).by_column.at(column_).origin, WindowOrigin::kByEye);
}

TEST_F(BrowseTest, TheOtherWindowsStayAsTheyAre) {
  const Windows before = load_windows(folder_.windows(), study_),
                after = save_shifted_window(folder_, study_, column_, 1);
  for (const auto& [column, window] : before.by_column) {
    if (column == column_) continue;
    EXPECT_EQ(after.by_column.at(column).first_level, window.first_level);
    EXPECT_EQ(after.by_column.at(column).origin, window.origin);
  }
}

TEST_F(BrowseTest, WindowsThatASessionWasMadeFromStay) {
  TrialLog log(folder_.responses(), true);
  SessionRequest request;
  request.participant = "P1";
  open_session(folder_, log, request);
  EXPECT_THAT(message_of<InputError>([&] { save_shifted_window(folder_, study_, column_, 1); }),
              HasSubstr("session 1 of P1"));
}

TEST_F(BrowseTest, ADifferenceIsGreyWhereNothingDiffers) {
  LdrImage a(2, 1), b(2, 1);
  a.values = {10, 20, 30, 40, 50, 60};
  b.values = {10, 18, 30, 140, 50, 60};
  EXPECT_EQ(make_difference(a, b, 4).values, (std::vector<std::uint8_t>{128, 136, 128, 0, 128, 128}));
}

TEST_F(BrowseTest, AThumbnailHoldsMeans) {
  LdrImage image(5, 2);  // the last column does not fill a pixel
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = static_cast<std::uint8_t>(i);
  const LdrImage small = make_thumbnail(image, 2);
  EXPECT_EQ(small.width, 2);
  EXPECT_EQ(small.height, 1);
  EXPECT_EQ(small.values, (std::vector<std::uint8_t>{9, 10, 11, 15, 16, 17}));
}

}  // namespace
}  // namespace equilux
