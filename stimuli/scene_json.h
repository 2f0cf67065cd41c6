// What reading a scene and making its meshes share. Private to this folder.
#pragma once

#include <filesystem>
#include <string>

#include "stimuli/scene.h"

namespace equilux {

Vec3 to_vec(const Json& json);
Placement make_placement(const Json& json);

/// Path of the file of a mesh that is read from one. errors: InputError that says which command brings it, if
/// the scene knows.
std::filesystem::path find_mesh_file(const Scene& scene, const std::string& mesh);

}  // namespace equilux
