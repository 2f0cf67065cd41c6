// Comma-separated values there and back.
#include "analysis/csv.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace equilux::tests
