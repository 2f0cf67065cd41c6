// Wavefront OBJ, read line by line. Private to this folder.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "stimuli/mesh.h"

namespace equilux {

/// Whether a file's name ends so, in whatever case; `extension` in small letters, with its dot.
bool has_extension(const std::filesystem::path& path, std::string_view extension);

/// True for a file that its ending or, where that names no format of ours, its first statement calls OBJ.
bool is_obj(const std::filesystem::path& path, std::string_view text);

/// The faces of an OBJ: polygons are cut into triangles, corners that have a normal keep it, the others get
/// zero. Points, lines, curves, texture coordinates, colours, groups and materials are not read. Adds to
/// `found` what a polygon has of degenerate triangles, and vertices that stand where another does. shape:
/// each corner has a vertex of its own. errors: InputError naming the line, for whatever would be another
/// shape if it were left out (surfaces, calls of other files, weights) and for what is not OBJ; at most 4,096
/// corners in a face.
TriangleMesh read_obj(const std::string& source, const std::string& text, MeshRepairs& found);

}  // namespace equilux
