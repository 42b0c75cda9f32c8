// Meshes from files.
#pragma once

#include <filesystem>

#include "core/mesh.h"

namespace atlas::scenes {

/// The triangles of an OBJ, PLY or STL file, coordinates times `scale`, equal corners joined, triangles
/// without area dropped. @throws InputError "PATH: reason" when the file is missing, of another kind or
/// unreadable, holds no triangles or a coordinate that is not finite, or spans more than a kilometre.
core::TriMesh ImportMesh(const std::filesystem::path& path, double scale);

}  // namespace atlas::scenes
