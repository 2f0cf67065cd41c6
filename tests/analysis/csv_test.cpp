// Comma-separated values there and back.
#include "analysis/csv.h"

#include <gtest/gtest.h>

#include "analysis/report_tables.h"
#include "base/error.h"

namespace equilux::tests {
namespace {

TEST(Csv, quotes_only_what_needs_it) {
  const Table table{{"a", "b"}, {{"plain", "with,comma"}, {"say \"no\"", "two\nlines"}, {"", " "}}};
  EXPECT_EQ(format_csv(table), "a,b\nplain,\"with,comma\"\n\"say \"\"no\"\"\",\"two\nlines\"\n, \n");
}

TEST(Csv, comes_back_as_it_went) {
  const Table table{{"a", "b, c", "\"d\""}, {{"", "\"", ","}, {"\n", "\r\n", "x"}, {"é", "0.073", ""}}};
  EXPECT_EQ(parse_csv(format_csv(table), "test"), table);
}

TEST(Csv, a_row_of_another_length_is_refused_with_its_line) {
  try {
    parse_csv("a,b\n1,2\n3\n", "cells.csv");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "cells.csv: line 3: expected 2 fields, got 1");
  }
}

TEST(Csv, text_that_breaks_off_is_refused) {
  EXPECT_THROW(parse_csv("", "test"), InputError);
  EXPECT_THROW(parse_csv("a,b\n1,2", "test"), InputError);
  EXPECT_THROW(parse_csv("a\n\"open", "test"), InputError);
  EXPECT_THROW(parse_csv("a\n\"x\"y\n", "test"), InputError);
}

// As a p of a thousand right answers is.
TEST(Csv, a_number_below_the_least_normal_one_becomes_one_of_json) {
  const Json rows = make_rows_json({"cells.csv", {{"p_guess"}, {{"8.289046e-317"}, {"0.5"}, {""}}}});
  EXPECT_EQ(rows.at(std::size_t{0}).at("p_guess").as_double(), 8.289046e-317);
  EXPECT_EQ(rows.at(std::size_t{1}).at("p_guess").as_double(), 0.5);
  EXPECT_TRUE(rows.at(std::size_t{2}).at("p_guess").is_null());
}

}  // namespace
}  // namespace equilux::tests
