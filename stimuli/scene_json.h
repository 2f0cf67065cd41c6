// What reading a scene and making its meshes share. Private to this folder.
#pragma once

#include <filesystem>
#include <string>

#include "stimuli/scene.h"

namespace equilux {

Vec3 to_vec(const Json& json);
Placement make_placement(const Json& json);

/// Members of a mesh, of which it has one: what it is made by.
inline constexpr const char* kMeshKinds[] = {"quad",   "box",  "lathe",   "sweep", "extrude",
                                             "sphere", "blob", "scatter", "file",  "group"};

/// The mesh of a geometry, or of a sculpture by its name. errors: InputError for an unknown one
const std::string& mesh_of(const Scene& scene, const std::string& geometry);

/// Path of the file of a mesh that is read from one. errors: InputError that says which command brings it, if
/// the scene knows.
std::filesystem::path find_mesh_file(const Scene& scene, const std::string& mesh);

}  // namespace equilux
