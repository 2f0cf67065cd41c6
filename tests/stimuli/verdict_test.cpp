// What was found holds until verify finds nothing.
#include "stimuli/verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class Verdict : public testing::Test {
 protected:
  void change(const std::filesystem::path& path) const { save_text(path, load_text(path) + "\n"); }

  const TempFolder own_;
  const StudyFolder folder_{own_.path()};
};

TEST_F(Verdict, IsNothingWhereNothingWasAskedOrFound) {
  EXPECT_THAT(find_verdict(folder_), IsEmpty());
  save_text(folder_.manifest(), "{}");
  save_verdict(folder_, {{"a", "b"}});
  save_verdict(folder_, {});
  EXPECT_THAT(find_verdict(folder_), IsEmpty());
  EXPECT_FALSE(std::filesystem::exists(folder_.verdict())) << "a whole set is the same, verified or not";
}

TEST_F(Verdict, TellsTheFirstThatWasFoundEvenIfTheRecordsChange) {
  for (const auto& record : {folder_.manifest(), folder_.layers()}) {
    for (const auto& each : {folder_.manifest(), folder_.layers()}) save_text(each, "{}");
    save_verdict(folder_, {{"G0-MS-ind-ref-v0", "a NaN"}, {"another", "thing"}});
    ASSERT_EQ(find_verdict(folder_).size(), 1u);
    EXPECT_EQ(find_verdict(folder_)[0].wrong, "G0-MS-ind-ref-v0: a NaN");
    EXPECT_THAT(find_verdict(folder_)[0].what, HasSubstr("when it is mended"));
    change(record);
    ASSERT_EQ(find_verdict(folder_).size(), 1u) << record;
    EXPECT_THAT(find_verdict(folder_)[0].what, HasSubstr("records were changed since")) << record;
    EXPECT_EQ(find_verdict(folder_)[0].wrong, "G0-MS-ind-ref-v0: a NaN");
  }
}

TEST_F(Verdict, GoesWhenTheFolderWasLookedAtAsBeforeAndNothingFound) {
  EXPECT_THAT(renew_verdict(folder_, {{"a", "b"}}, false), SizeIs(1));
  EXPECT_EQ(find_verdict(folder_).size(), 1u) << "without records too";
  EXPECT_THAT(renew_verdict(folder_, {}, false), IsEmpty());
  EXPECT_THAT(find_verdict(folder_), IsEmpty());
  EXPECT_THAT(renew_verdict(folder_, {{"a", "b"}, {"c", "d", true}}, true), SizeIs(2));
  EXPECT_THAT(renew_verdict(folder_, {}, false), SizeIs(1)) << "the study file was not looked at";
  ASSERT_EQ(find_verdict(folder_).size(), 1u);
  EXPECT_THAT(find_verdict(folder_)[0].what, HasSubstr("verify --study"));
  EXPECT_THAT(renew_verdict(folder_, {}, true), IsEmpty());
  EXPECT_THAT(find_verdict(folder_), IsEmpty());
}

TEST_F(Verdict, ThatIsDamagedIsRefused) {
  for (const auto& [text, place] : std::vector<std::pair<std::string, std::string>>{
           {"[", "verdict.json"},
           {R"({"schema": "equilux-report"})", "/schema: expected"},
           {R"({"schema": "equilux-verdict", "findings": "1"})", "/findings: expected a whole number"},
           {R"({"schema": "equilux-verdict", "findings": 1, "manifest": ""})",
            "/layers: expected a string"}}) {
    save_text(folder_.verdict(), text);
    EXPECT_THAT(message_of<InputError>([&] { find_verdict(folder_); }), HasSubstr(place)) << text;
  }
}

}  // namespace
}  // namespace equilux
