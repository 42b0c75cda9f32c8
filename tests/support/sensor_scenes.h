// Meshes, scenes, rays and a brute-force ray oracle for the sensor tests.
#pragma once

#include <vector>

#include "core/rng.h"
#include "scenes/scene_spec.h"

namespace atlas::sim::testing {

/// Unrotated.
inline core::Pose At(double x, double y, double z) {
  return core::MakePose(core::Mat3::Identity(), core::Vec3(x, y, z));
}

inline core::TriMesh BoxMesh(const core::Vec3& half_size,
                             const core::Pose& T_map_box = core::Pose::Identity()) {
  core::TriMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const core::Vec3 sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    mesh.vertices.push_back((T_map_box * half_size.cwiseProduct(sign)).cast<float>());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A surface of revolution about z: rings of `segments` vertices at the given radii and heights.
inline core::TriMesh LatheMesh(const std::vector<core::Vec2>& radius_and_z, int segments,
                               const core::Pose& T_map_mesh = core::Pose::Identity()) {
  core::TriMesh mesh;
  const auto n = static_cast<uint32_t>(segments);
  for (const core::Vec2& ring : radius_and_z) {
    for (uint32_t s = 0; s < n; ++s) {
      const double angle = 2.0 * core::kPi * s / segments;
      const core::Vec3 p(ring.x() * std::cos(angle), ring.x() * std::sin(angle), ring.y());
      mesh.vertices.push_back((T_map_mesh * p).cast<float>());
    }
  }
  for (uint32_t r = 0; r + 1 < radius_and_z.size(); ++r) {
    for (uint32_t s = 0; s < n; ++s) {
      const uint32_t a = r * n + s, b = r * n + (s + 1) % n;
      mesh.triangles.push_back({a, b, a + n});
      mesh.triangles.push_back({b, b + n, a + n});
    }
  }
  return mesh;
}

inline core::TriMesh SphereMesh(double radius, int segments, const core::Pose& T_map_sphere) {
  std::vector<core::Vec2> profile;
  for (int i = 0; i <= segments / 2; ++i) {
    const double angle = 2.0 * core::kPi * i / segments;
    profile.emplace_back(radius * std::sin(angle), -radius * std::cos(angle));
  }
  return LatheMesh(profile, segments, T_map_sphere);
}

inline core::TriMesh CylinderMesh(double radius, double half_length, int segments,
                                  const core::Pose& T_map_cylinder) {
  return LatheMesh({{0.0, -half_length}, {radius, -half_length}, {radius, half_length}, {0.0, half_length}},
                   segments, T_map_cylinder);
}

inline scenes::ScenePart Part(core::TriMesh mesh, double ray_transmission = 0.0) {
  scenes::ScenePart part;
  part.mesh = std::move(mesh);
  part.ray_transmission = ray_transmission;
  return part;
}

inline scenes::SceneSpec Scene(std::vector<scenes::ScenePart> parts) {
  scenes::SceneSpec scene;
  scene.parts = std::move(parts);
  return scene;
}

inline core::Vec3 RandomDirection(core::Rng* rng) {
  core::Vec3 d;
  do {
    d = core::Vec3(rng->Normal(), rng->Normal(), rng->Normal());
  } while (d.norm() < 1e-3);
  return d.normalized();
}

inline core::Pose RandomPose(core::Rng* rng, double extent_m) {
  const Eigen::Quaterniond q(rng->Normal(), rng->Normal(), rng->Normal(), rng->Normal());
  core::Vec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = rng->Uniform(-extent_m, extent_m);
  return core::MakePose(q.normalized().toRotationMatrix(), p);
}

inline std::vector<core::Ray> RandomRays(core::Rng* rng, int count, double extent_m) {
  std::vector<core::Ray> rays;
  for (int i = 0; i < count; ++i) {
    const core::Vec3 origin = RandomPose(rng, extent_m).translation();
    rays.push_back({origin.cast<float>(), RandomDirection(rng).cast<float>().normalized()});
  }
  return rays;
}

/// Moeller-Trumbore in double over every triangle: distance to the nearest within (0, max_range_m], or -1.
inline double BruteForceRange(const std::vector<core::TriMesh>& meshes, const core::Ray& ray,
                              double max_range_m, int* mesh_index = nullptr) {
  const core::Vec3 origin = ray.origin.cast<double>(), direction = ray.direction.cast<double>();
  double nearest = -1.0;
  for (size_t m = 0; m < meshes.size(); ++m) {
    for (const auto& t : meshes[m].triangles) {
      const core::Vec3 a = meshes[m].vertices[t[0]].cast<double>();
      const core::Vec3 e1 = meshes[m].vertices[t[1]].cast<double>() - a;
      const core::Vec3 e2 = meshes[m].vertices[t[2]].cast<double>() - a;
      const core::Vec3 p = direction.cross(e2), s = origin - a, q = s.cross(e1);
      const double det = e1.dot(p);
      if (det == 0.0) continue;
      const double u = s.dot(p) / det, v = direction.dot(q) / det, range = e2.dot(q) / det;
      if (u < 0.0 || v < 0.0 || u + v > 1.0 || range <= 0.0 || range > max_range_m) continue;
      if (nearest >= 0.0 && range >= nearest) continue;
      nearest = range;
      if (mesh_index != nullptr) *mesh_index = static_cast<int>(m);
    }
  }
  return nearest;
}

}  // namespace atlas::sim::testing
