// Convex hulls small enough for physics.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace atlas::scenes {

/// The hull of the points; of more than 100, of those that are extreme in some of 256 directions spread over
/// the sphere: exact for bodies of few corners, within 1 % of the body's size for round ones. Empty when the
/// points span no volume.
core::TriMesh ConvexHull(const std::vector<core::Vec3f>& points);

}  // namespace atlas::scenes
