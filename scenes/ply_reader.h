// PLY meshes, ASCII and binary.
//
// Read here, since assimp 5.2 never returns from a PLY file that ends early.
#pragma once

#include <string_view>

#include "core/mesh.h"

namespace atlas::scenes {

/// Vertices and faces (polygons are split into fans) of a PLY file's bytes. @throws InputError with the
/// reason: a bad header, data that ends early, an index out of range.
core::TriMesh ParsePly(std::string_view bytes);

}  // namespace atlas::scenes
