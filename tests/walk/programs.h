// The three programs as their users start them, for walks through all of them.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/experiment/child.h"

namespace equilux {

using Words = std::vector<std::string>;

/// Runs `equilux-NAME words...` to its end. No test's output is a terminal, so neither stream may hold a
/// carriage return or an escape code.
inline ChildResult run_equilux(const std::string& name, const Words& words) {
  const ChildResult result = Child(EQUILUX_BIN_DIR "/equilux-" + name, words).wait();
  EXPECT_EQ((result.out + result.err).find_first_of("\r\033"), std::string::npos)
      << fmt::format("{} {}", name, fmt::join(words, " "));
  return result;
}

/// The same where nothing but success will do; gives standard output.
inline std::string run_well(const std::string& name, const Words& words) {
  const ChildResult result = run_equilux(name, words);
  EXPECT_EQ(result.exit_code, 0) << fmt::format("{} {}\n{}", name, fmt::join(words, " "), result.err);
  return result.out;
}

}  // namespace equilux
