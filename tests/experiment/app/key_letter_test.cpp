// Names as GLFW gives them on keyboards of several countries.
#include "experiment/app/key_letter.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

namespace equilux {
namespace {

TEST(KeyLetter, IsTheOneOnTheKey) {
  EXPECT_EQ(find_letter(GLFW_KEY_W, "w"), GLFW_KEY_W);
  EXPECT_EQ(find_letter(GLFW_KEY_Z, "w"), GLFW_KEY_W) << "French";
  EXPECT_EQ(find_letter(GLFW_KEY_A, "z"), GLFW_KEY_Z);
}

TEST(KeyLetter, IsByItsPlaceWhereNoLatinOnesAreWritten) {
  EXPECT_EQ(find_letter(GLFW_KEY_LEFT, nullptr), GLFW_KEY_LEFT);
  EXPECT_EQ(find_letter(GLFW_KEY_W, "\u0446"), GLFW_KEY_W) << "Cyrillic";
  EXPECT_EQ(find_letter(GLFW_KEY_W, "\u03c2"), GLFW_KEY_W) << "Greek";
  EXPECT_EQ(find_letter(GLFW_KEY_W, "\u3066"), GLFW_KEY_W) << "Japanese";
}

TEST(KeyLetter, IsNoneWhereAnotherLatinOneOrASignIs) {
  for (const char* name : {"\u00e9", "\u0131", "\u011f", ";", "1", "ss"})
    EXPECT_EQ(find_letter(GLFW_KEY_W, name), GLFW_KEY_UNKNOWN) << name;
}

}  // namespace
}  // namespace equilux
