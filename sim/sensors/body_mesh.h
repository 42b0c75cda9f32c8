// A rigid body's triangles at a pose, and distances to them.
#pragma once

#include "core/mesh.h"

namespace atlas::sim {

class BodyMesh {
 public:
  explicit BodyMesh(const core::TriMesh& mesh_body);

  void SetPose(const core::Pose& T_map_body) { T_body_map_ = T_map_body.inverse(); }

  /// Whether a triangle lies within `margin_m` of `p_map`.
  bool IsWithin(const core::Vec3& p_map, double margin_m) const;
  /// An upper bound on the distance from `p_map` to any point of the body (of its bounding box); 0 when
  /// empty.
  double Reach(const core::Vec3& p_map) const;

 private:
  core::TriMesh mesh_;
  core::Box3 bounds_body_;
  core::Pose T_body_map_ = core::Pose::Identity();
};

/// Squared distance from `p` to triangle (a, b, c).
double SquaredDistanceToTriangle(const core::Vec3& p, const core::Vec3& a, const core::Vec3& b,
                                 const core::Vec3& c);

}  // namespace atlas::sim
