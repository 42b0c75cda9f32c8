// Physics for meshes that are not convex.
//
// MuJoCo collides a mesh as its convex hull, which would fill every arch and doorway. Instead each triangle
// that the robot can reach becomes a thin prism behind its face; rays and pictures keep the mesh.
#pragma once

#include <vector>

#include "scenes/scene_spec.h"

namespace atlas::scenes {

struct PrismOptions {
  double reach_z_m = 1.3;     ///< triangles wholly above are left out
  double thickness_m = 0.02;  ///< behind the face
  int most_prisms = 600;      ///< a mesh that needs more is simplified first
};

/// Prisms over the reachable triangles of `mesh` (map frame). Where they exceed `most_prisms`, their vertices
/// are first merged on a grid of 5 cm, or the least multiple of 1.25 of it that brings their number down: the
/// felt surface then differs from the seen one by at most that cell's diagonal.
std::vector<CollisionShape> TrianglePrisms(const core::TriMesh& mesh, const PrismOptions& options);

/// Whether the mesh is closed and no corner stands more than 1 mm before any face. @pre few thousand
/// triangles.
bool IsConvex(const core::TriMesh& mesh);

}  // namespace atlas::scenes
