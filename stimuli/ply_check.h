// Whether a PLY file is what its header says. Private to this folder.
#pragma once

#include <string>

namespace equilux {

/// False for a file that does not begin as PLY. assimp takes memory for every count that a PLY file states,
/// and reads a header without an end for ever: so the header must end within 65,536 bytes and have lines of
/// PLY's words alone; it may declare as many elements as the file has bytes; lists are counted in one byte
/// where they are binary; in text, each element is one line of exactly its values. It also reads as another
/// shape what it does not expect: so vertices come first, with x, y and z, each element stands once, faces
/// have one list of integers, no surface is of strips, and each word of text is a whole value of its type.
/// errors: InputError
bool check_ply(const std::string& source, const std::string& bytes);

}  // namespace equilux
