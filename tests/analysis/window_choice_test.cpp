// Windows around cuts, kept inside the scale, written so that they load again.
#include "analysis/window_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/analysis/columns.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {
namespace {

const std::vector<int> kLevels = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10};

std::optional<int> choose(const ColumnCounts& counts) {
  return choose_first_level(counts, kLevels, Rule::kPaper);
}

TEST(WindowChoice, has_two_levels_on_either_side_of_a_cut) {
  EXPECT_EQ(choose(make_window(3, {12, 12, 6, 6})), 3);
  EXPECT_EQ(choose(make_column({{1, {12, 12}}, {4, {11, 12}}, {5, {5, 12}}, {9, {6, 12}}})), 3);
  EXPECT_EQ(choose(make_window(0, {12, 6, 6, 6})), 0) << "never before the first level";
  EXPECT_EQ(choose(make_window(7, {12, 12, 12, 6})), 7) << "never beyond the last";
}

TEST(WindowChoice, moves_on_where_the_cut_lies_beyond_the_tested_levels) {
  EXPECT_EQ(choose(make_window(5, {6, 6, 6, 6})), 2) << "less clamped, overlapping in C5";
  EXPECT_EQ(choose(make_window(2, {12, 12, 12, 12})), 5) << "more clamped, overlapping in C5";
  EXPECT_EQ(choose(make_window(7, {12, 12, 12, 12})), 7);
  EXPECT_EQ(choose(make_window(1, {6, 6, 6, 6})), 0);
}

TEST(WindowChoice, of_an_untested_column_is_none) { EXPECT_EQ(choose(make_column({})), std::nullopt); }

TEST(WindowChoice, from_a_pilot_says_so_and_keeps_what_the_pilot_did_not_test) {
  const Study study = load_protocol("pocket");
  Windows standing = load_windows(study.windows_path, study);
  const Column first = enumerate_columns(study)[0], second = enumerate_columns(study)[1];
  standing.by_column[second] = {6, WindowOrigin::kByEye};
  Tally tally = tally_answers({}, study);
  for (int level = 0; level < 11; ++level) tally[{first, level, false}] = {level < 6 ? 12 : 5, 12};
  const auto windows = choose_windows(study, tally, standing, Rule::kPaper, WindowOrigin::kPilot);
  EXPECT_EQ(windows.at(first).first_level, 4);
  EXPECT_EQ(windows.at(first).origin, WindowOrigin::kPilot);
  EXPECT_EQ(windows.at(second).first_level, 6);
  EXPECT_EQ(windows.at(second).origin, WindowOrigin::kByEye);
  const TempFolder folder;
  save_text(folder / "windows.json", format_windows(windows, study, "test"));
  const Windows again = load_windows(folder / "windows.json", study);
  for (const auto& [column, window] : windows) {
    EXPECT_EQ(again.by_column.at(column).first_level, window.first_level);
    EXPECT_EQ(again.by_column.at(column).origin, window.origin);
  }
}

// A study of C0 to C3 and C6 to C10: no window spans the gap.
TEST(WindowChoice, begins_where_the_study_has_four_adjacent_levels) {
  const std::vector<int> levels{0, 1, 2, 3, 6, 7, 8, 9, 10};
  const auto choose = [&](const std::vector<std::pair<int, Count>>& tested) {
    ColumnCounts counts = make_column(tested);
    std::erase_if(counts, [](const LevelCount& count) { return count.level == 4 || count.level == 5; });
    return choose_first_level(counts, levels, Rule::kPaper);
  };
  EXPECT_EQ(choose({{3, {12, 12}}, {6, {3, 12}}}), 6) << "wants C4";
  EXPECT_EQ(choose({{2, {12, 12}}, {3, {3, 12}}}), 0) << "wants C1";
  EXPECT_EQ(choose({{6, {12, 12}}, {7, {3, 12}}}), 6) << "wants C5";
  EXPECT_EQ(choose({{10, {12, 12}}}), 7);
  const ColumnCounts counts = make_column({{2, {3, 12}}});
  EXPECT_THAT(message_of<InputError>([&] {
                choose_first_level(counts, {0, 2, 4, 6, 8, 10}, Rule::kPaper);
              }),
              testing::HasSubstr("/clamp_levels: expected 4 adjacent clamp levels, got C0 C2 C4"));
}

TEST(WindowChoice, from_a_prediction_cuts_where_it_crosses_three_quarters) {
  const Study study = load_protocol("pocket");
  std::string text = "column,clamp,proportion\n";
  const char* proportions[] = {"1", "1", ".99", ".9", ".76", ".74", ".6", ".5", ".5", ".5", "5e-1"};
  for (int level = 0; level < 11; ++level)
    text += fmt::format("G0-MS-ind-1k,C{},{}\n", level, proportions[level]);
  const Tally tally = parse_prediction(text, "prediction.csv", study);
  const auto windows = choose_windows(study, tally, load_windows(study.windows_path, study), Rule::kPaper,
                                      WindowOrigin::kPredicted);
  EXPECT_EQ(windows.at(enumerate_columns(study)[0]).first_level, 3);
}

std::string find_error(const std::string& text) {
  try {
    parse_prediction(text, "prediction.csv", load_protocol("pocket"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(WindowChoice, takes_a_prediction_as_spreadsheets_write_it) {
  const Study study = load_protocol("pocket");
  const auto parse = [&](const std::string& text) { return parse_prediction(text, "prediction.csv", study); };
  const Tally plain = parse("column,clamp,proportion\nG0-MS-ind-1k,C1,0.9\nG0-MS-ind-1k,C2,0.8\n");
  EXPECT_EQ(plain.at({enumerate_columns(study)[0], 2, false}).k, 800000);
  for (const char* text : {"column,clamp,proportion\r\nG0-MS-ind-1k,C1,0.9\r\nG0-MS-ind-1k,C2,0.8\r\n",
                           "\xEF\xBB\xBF"
                           "column,clamp,proportion\nG0-MS-ind-1k,C1,0.9\nG0-MS-ind-1k,C2,0.8\n",
                           "column,clamp,proportion\nG0-MS-ind-1k,C1,0.9\nG0-MS-ind-1k,C2,0.8",
                           "column,clamp,proportion\nG0-MS-ind-1k,C1,0.9\nG0-MS-ind-1k,C2,0.8\n\n\r\n \n"})
    EXPECT_EQ(parse(text), plain) << text;
}

TEST(WindowChoice, of_a_normalised_study_takes_levels_as_its_own_tables_spell_them) {
  const Study study = load_protocol("normalisation");
  const std::string column = format_key(enumerate_columns(study)[0]);
  const auto parse = [&](const char* level) {
    return parse_prediction(fmt::format("column,clamp,proportion\n{},{},0.9\n", column, level),
                            "prediction.csv", study);
  };
  EXPECT_EQ(parse("C4n"), parse("C4"));
  EXPECT_EQ(parse("C4n").at({enumerate_columns(study)[0], 4, true}).k, 900000);
  EXPECT_THROW(parse("C4nn"), InputError);
  EXPECT_NE(find_error("column,clamp,proportion\nG0-MS-ind-1k,C4n,1\n"), "")
      << "a plain study has no such level";
}

TEST(WindowChoice, names_what_is_wrong_with_a_prediction) {
  for (const auto& [text, error] : std::vector<std::pair<std::string, std::string>>{
           {"column,clamp\nG0-MS-ind-1k,C1\n",
            "line 1: expected the columns column, clamp and proportion, got no"},
           {"", "line 1: expected the columns"},
           {"column,clamp,proportion,clamp\nG0-MS-ind-1k,C1,1,C2\n",
            "line 1: expected columns of different names"},
           {"column,clamp,proportion\r\n\r\n", "line 2: expected a row for each cell"},
           {"column,clamp,proportion\nG0-MS-ind-1k,C1,1\n\nG0-MS-ind-1k,C2,1\n", "line 3: expected 3 fields"},
           {"column,clamp,proportion\nG0-MS-ind-1k,C1,1\nG0-MS-ind-1k,C2,1\nG0-MS-ind-1k,C1,1\n",
            "line 4: expected one row for each cell, got G0-MS-ind-1k-C1 again, as in line 2"}})
    EXPECT_EQ(find_error(text).find("prediction.csv: " + error), 0U) << find_error(text);
  for (const char* value : {"", "1.5", "-0.1", "nan", "half", "0.5x"}) {
    const std::string error = find_error(fmt::format("column,clamp,proportion\nG0-MS-ind-1k,C1,{}\n", value));
    EXPECT_NE(error.find("line 2: expected a proportion of 0 to 1"), std::string::npos)
        << value << ": " << error;
  }
  EXPECT_NE(find_error("column,clamp,proportion\nG3-MS-ind-1k,C1,1\n").find("a cell of the study pocket"),
            std::string::npos);
}

}  // namespace
}  // namespace equilux::tests
