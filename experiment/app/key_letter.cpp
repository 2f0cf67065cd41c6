// By the name of the key.
#include "experiment/app/key_letter.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace equilux {
namespace {

// UTF-8 of letters beyond those of Latin alphabets.
constexpr unsigned char kFirstBeyondLatin = 0xCA;

}  // namespace

int find_letter(int key, const char* name) {
  if (!name || static_cast<unsigned char>(name[0]) >= kFirstBeyondLatin) return key;
  const bool is_letter = name[0] >= 'a' && name[0] <= 'z' && name[1] == '\0';
  return is_letter ? GLFW_KEY_A + (name[0] - 'a') : GLFW_KEY_UNKNOWN;
}

}  // namespace equilux
