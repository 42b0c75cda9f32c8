// The robot's shapes as triangles, so that its own LiDAR and camera can see it.
#pragma once

#include <vector>

#include "core/mesh.h"

struct mjModel_;

namespace atlas::sim {

/// Visible geoms (group 2; where a body has none, its collision shapes) of body `body`, in the body's frame.
/// Geoms named lidar* are the sensor's own housing and stay out: rays start within them.
core::TriMesh BodyMesh(const mjModel_& model, int body);

/// One geom in its body's frame; empty for kinds without a surface of their own (planes, height fields).
core::TriMesh GeomMesh(const mjModel_& model, int geom);

}  // namespace atlas::sim
