// Letters on keys.
#pragma once

namespace equilux {

/// The GLFW key of the letter on a key: GLFW names keys by their places on an American keyboard. `name`: what
/// glfwGetKeyName says of it. By its place where that is null, as of arrows, or no Latin letters are written;
/// GLFW_KEY_UNKNOWN where something else than a letter from A to Z is on it.
int find_letter(int key, const char* name);

}  // namespace equilux
