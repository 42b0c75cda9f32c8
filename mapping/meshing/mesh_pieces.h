// Connected pieces of a mesh.
#pragma once

#include "core/mesh.h"

namespace atlas::mapping {

/// Leaves out the pieces (triangles that hang together by vertices) of less area than `min_area_m2`, and
/// vertices that no triangle uses. The order of what remains is kept.
void DropSmallPieces(double min_area_m2, core::TriMesh* mesh);

}  // namespace atlas::mapping
