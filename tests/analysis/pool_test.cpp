// Folders of one study whose selections, pictures or windows are not the same.
#include "analysis/pool.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "tests/analysis/planted_report.h"

namespace equilux::tests {
namespace {

// What stands in a folder of the pocket study, with a manifest of two pictures.
ReportSources make_sources(const PlantedStudy& planted) {
  ReportSources sources{planted.selection, load_windows(planted.study.windows_path, planted.study),
                        Manifest{}};
  sources.manifest->seed = 1;
  sources.manifest->pictures["G0-MS-ind-1k-C4-v0"] = {"pictures/a.png", "aaaa", "", nullptr};
  sources.manifest->pictures["G0-MS-ind-ref-v0"] = {"pictures/b.png", "bbbb", "", nullptr};
  sources.protocol = load_session_protocol(planted.study.session_path);
  return sources;
}

TEST(PoolSources, keeps_what_is_the_same_in_all) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const ReportSources all = pool_sources({make_sources(planted), make_sources(planted)}, {"a", "b"});
  ASSERT_TRUE(all.manifest && all.windows && all.selection && all.protocol);
  EXPECT_EQ(all.manifest->pictures.size(), 2U);
  EXPECT_EQ(digest_selection(*all.selection), digest_selection(planted.selection));
  EXPECT_TRUE(all.selections.empty());
}

TEST(PoolSources, leaves_out_a_manifest_of_other_pictures_or_another_seed_and_other_windows) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const ReportSources one = make_sources(planted);
  ReportSources other = one;
  other.manifest->pictures["G0-MS-ind-1k-C4-v0"].digest = "cccc";
  EXPECT_FALSE(pool_sources({one, other}, {"a", "b"}).manifest);
  other = one;
  other.manifest->seed = 2;
  EXPECT_FALSE(pool_sources({one, other}, {"a", "b"}).manifest);
  other = one;
  other.manifest->pictures.erase("G0-MS-ind-ref-v0");
  EXPECT_FALSE(pool_sources({one, other}, {"a", "b"}).manifest);
  other = one;
  other.manifest.reset();
  EXPECT_FALSE(pool_sources({one, other}, {"a", "b"}).manifest);
  EXPECT_FALSE(pool_sources({other, one}, {"a", "b"}).manifest);
  other = one;
  other.windows->digest = std::string(64, 'e');
  other.protocol->digest = std::string(64, 'e');
  EXPECT_FALSE(pool_sources({one, other}, {"a", "b"}).windows);
  EXPECT_FALSE(pool_sources({one, other}, {"a", "b"}).protocol);
}

TEST(PoolSources, of_other_selections_keeps_each_digest_and_invents_none) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const ReportSources one = make_sources(planted);
  ReportSources other = one;
  SelectedColumn& column = other.selection->columns.front();
  other.selection->rule = "isotonic";
  other.selection->answers_digest = std::string(64, 'e');
  column.artifact_cut = 9;
  column.levels = {9, 10};
  const ReportSources all = pool_sources({one, other}, {"a", "b"});
  ASSERT_TRUE(all.selection);
  EXPECT_EQ(all.selection->rule, "");
  EXPECT_EQ(all.selection->answers_digest, "");
  EXPECT_FALSE(all.selection->columns[0].artifact_cut);
  EXPECT_EQ(all.selection->columns[1].artifact_cut, planted.selection.columns[1].artifact_cut);
  for (const int level : {9, 10})
    EXPECT_EQ(
        std::count(all.selection->columns[0].levels.begin(), all.selection->columns[0].levels.end(), level),
        1);
  ASSERT_EQ(all.selections.size(), 2U);
  EXPECT_EQ(all.selections[0].folder, "a");
  EXPECT_EQ(all.selections[0].digest, digest_selection(*one.selection));
  EXPECT_EQ(all.selections[1].answers_digest, std::string(64, 'e'));
  Report report = make_planted_report(planted);
  report.selection = all.selection;
  report.selections = all.selections;
  const std::string page = format_page({report});
  EXPECT_TRUE(has(page, "<dt>selection of b: digest</dt><dd><span class=\"digest\">" +
                            digest_selection(*other.selection)));
  EXPECT_FALSE(has(page, digest_selection(*all.selection))) << "nobody made that selection";
  other.selection.reset();
  const ReportSources some = pool_sources({one, other}, {"a", "b"});
  EXPECT_FALSE(some.selection);
  EXPECT_EQ(some.selections.size(), 1U);
}

TEST(PoolWarnings, name_the_folders_whose_pictures_or_windows_differ) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const auto kind = SubjectKind::kPlanted;
  const Evidence ours{kind, make_evidence(planted, Experiment::kArtifact, kind, 12),
                      make_evidence(planted, Experiment::kMaterial, kind, 14)};
  const ReportSources one = make_sources(planted);
  ReportSources other = one;
  Evidence theirs = ours;
  const auto warnings = [&] { return find_pool_warnings({{"a", ours, one}, {"b", theirs, other}}); };
  EXPECT_TRUE(warnings().empty());
  other.manifest->pictures["G0-MS-ind-1k-C4-v0"].digest = "cccc";
  EXPECT_EQ(warnings(), std::vector<std::string>{
                            "Answers about different pictures are added up: of 2 pictures that a and b both "
                            "have, 1 differs, the first G0-MS-ind-1k-C4-v0."});
  other.manifest.reset();
  EXPECT_TRUE(warnings().empty());
  for (SessionRow& row : theirs.artifact.finished) row.digests.manifest = std::string(64, 'd');
  EXPECT_EQ(warnings(), std::vector<std::string>{
                            "Answers about different pictures are added up: artifact sessions recorded "
                            "different sets of pictures, a (bbbbbbbbbbbb...); b (dddddddddddd...)."});
  for (SessionRow& row : theirs.artifact.finished) row.digests.windows = std::string(64, 'w');
  EXPECT_TRUE(warnings().empty()) << "other windows show other pictures";
  other.windows->digest = std::string(64, 'w');
  ASSERT_EQ(warnings().size(), 1U);
  EXPECT_TRUE(has(warnings()[0], "The clamp windows differ between folders"));
  EXPECT_TRUE(has(warnings()[0], "b (wwwwwwwwwwww...)"));
}

}  // namespace
}  // namespace equilux::tests
