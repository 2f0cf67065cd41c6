// Numbers of cells and of their keys.
#include "protocols/cell_numbers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

Cell make_cell(const std::string& geometry, int level, bool normalised = false) {
  return {{{geometry, "MR", Illumination::kIndirect}, 100000}, level, normalised};
}

TEST(CellNumbers, AreGivenInTheOrderOfComingAndOnce) {
  CellNumbers numbers;
  const std::vector<Cell> cells = {make_cell("G1", 4), make_cell("G1", 4, true), make_cell("G", 4),
                                   make_cell("Gallery1", 4), make_cell("G1", 5)};
  for (int round = 0; round < 2; ++round) {
    for (std::uint32_t i = 0; i < cells.size(); ++i) EXPECT_EQ(numbers.number_of(cells[i]), i);
  }
  EXPECT_EQ(numbers.cells(), cells);
}

TEST(CellReader, NumbersEachKeyOnceAndFindsThoseThatItRead) {
  CellReader reader;
  EXPECT_EQ(reader.find("G1-MR-ind-100k-C4"), std::nullopt);
  EXPECT_EQ(reader.number_of("G1-MR-ind-100k-C4", "a", "b"), 0U);
  EXPECT_EQ(reader.number_of("G2-MR-ind-100k-C4n", "a", "b"), 1U);
  EXPECT_EQ(reader.number_of("G1-MR-ind-100k-C4", "a", "b"), 0U);
  EXPECT_EQ(reader.find("G2-MR-ind-100k-C4n"), 1U);
  EXPECT_EQ(reader.cells(), (std::vector<Cell>{make_cell("G1", 4), make_cell("G2", 4, true)}));
  EXPECT_EQ(reader.read("G2-MR-ind-100k-C4n", "a", "b"), make_cell("G2", 4, true));
}

TEST(CellReader, KeepsNothingOfWhatIsNoKey) {
  CellReader reader;
  EXPECT_THAT(message_of<InputError>([&] { reader.number_of("G1", "log", "trial/cell"); }),
              testing::StartsWith("log: trial/cell: expected a cell"));
  EXPECT_EQ(reader.find("G1"), std::nullopt);
  EXPECT_TRUE(reader.cells().empty());
}

}  // namespace
}  // namespace equilux
