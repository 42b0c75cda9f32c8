#include "sim/world/robot_meshes.h"

#include <mujoco/mujoco.h>

#include <cstring>

namespace atlas::sim {
namespace {

using core::TriMesh;
using core::Vec3f;

constexpr int kSegments = 16;
constexpr int kVisibleGroup = 2, kCollisionGroup = 3;

TriMesh Box(const mjtNum* half) {
  TriMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const auto sign = [&](int axis) { return (i >> axis & 1) ? 1.0 : -1.0; };
    mesh.vertices.emplace_back(
        core::Vec3(sign(0) * half[0], sign(1) * half[1], sign(2) * half[2]).cast<float>());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

struct Ring {
  double radius, z;
};

/// Surface of revolution about z through `rings`, bottom first, closed by points where the radius is 0.
TriMesh Revolve(const std::vector<Ring>& rings) {
  TriMesh mesh;
  for (const Ring& ring : rings) {
    for (int s = 0; s < kSegments; ++s) {
      const double a = 2.0 * core::kPi * s / kSegments;
      mesh.vertices.emplace_back(
          core::Vec3(ring.radius * std::cos(a), ring.radius * std::sin(a), ring.z).cast<float>());
    }
  }
  for (uint32_t r = 0; r + 1 < rings.size(); ++r) {
    for (uint32_t s = 0; s < kSegments; ++s) {
      const uint32_t a = r * kSegments + s, b = r * kSegments + (s + 1) % kSegments;
      const uint32_t c = a + kSegments, d = b + kSegments;
      if (rings[r].radius > 0.0) mesh.triangles.push_back({a, b, d});
      if (rings[r + 1].radius > 0.0) mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

/// A sphere cut at its equator, `half_length` apart.
TriMesh Capsule(double radius, double half_length) {
  constexpr int kRings = 4;
  std::vector<Ring> rings;
  for (int i = -kRings; i <= kRings; ++i) {
    const double a = 0.5 * core::kPi * i / kRings;
    const double r = std::abs(i) == kRings ? 0.0 : radius * std::cos(a);
    if (i <= 0) rings.push_back({r, -half_length + radius * std::sin(a)});
    if (i >= 0) rings.push_back({r, half_length + radius * std::sin(a)});
  }
  return Revolve(rings);
}

TriMesh ModelMesh(const mjModel& m, int mesh_id) {
  TriMesh mesh;
  for (int v = 0; v < m.mesh_vertnum[mesh_id]; ++v) {
    mesh.vertices.push_back(Eigen::Map<const Vec3f>(m.mesh_vert + 3 * (m.mesh_vertadr[mesh_id] + v)));
  }
  for (int f = 0; f < m.mesh_facenum[mesh_id]; ++f) {
    const int* face = m.mesh_face + 3 * (m.mesh_faceadr[mesh_id] + f);
    mesh.triangles.push_back(
        {static_cast<uint32_t>(face[0]), static_cast<uint32_t>(face[1]), static_cast<uint32_t>(face[2])});
  }
  return mesh;
}

bool IsLidarHousing(const mjModel& m, int g) {
  const char* name = mj_id2name(&m, mjOBJ_GEOM, g);
  return name != nullptr && std::strncmp(name, "lidar", 5) == 0;
}

}  // namespace

TriMesh GeomMesh(const mjModel& m, int g) {
  const mjtNum* size = m.geom_size + 3 * g;
  TriMesh mesh;
  switch (m.geom_type[g]) {
    case mjGEOM_BOX:
      mesh = Box(size);
      break;
    case mjGEOM_SPHERE:
      mesh = Capsule(size[0], 0.0);
      break;
    case mjGEOM_CAPSULE:
      mesh = Capsule(size[0], size[1]);
      break;
    case mjGEOM_CYLINDER:
      mesh = Revolve({{0.0, -size[1]}, {size[0], -size[1]}, {size[0], size[1]}, {0.0, size[1]}});
      break;
    case mjGEOM_ELLIPSOID:
      mesh = Capsule(1.0, 0.0);
      for (Vec3f& v : mesh.vertices) v = v.cwiseProduct(core::Vec3(size[0], size[1], size[2]).cast<float>());
      break;
    case mjGEOM_MESH:
      mesh = ModelMesh(m, m.geom_dataid[g]);
      break;
    default:
      break;
  }
  const mjtNum* q = m.geom_quat + 4 * g;
  mesh.Transform(core::MakePose(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
                                Eigen::Map<const core::Vec3>(m.geom_pos + 3 * g)));
  return mesh;
}

TriMesh BodyMesh(const mjModel& model, int body) {
  for (const int group : {kVisibleGroup, kCollisionGroup}) {
    TriMesh mesh;
    for (int g = model.body_geomadr[body]; g < model.body_geomadr[body] + model.body_geomnum[body]; ++g) {
      if (model.geom_group[g] == group && !IsLidarHousing(model, g)) mesh.Append(GeomMesh(model, g));
    }
    if (!mesh.triangles.empty()) return mesh;
  }
  return {};
}

}  // namespace atlas::sim
