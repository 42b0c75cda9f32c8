// Worlds of boxes, and an exact ray caster of them that knows nothing of triangles.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/lidar_model.h"
#include "experiments/judge/attainable.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "scenes/scene_spec.h"

namespace atlas::tests {

inline core::TriMesh BoxMesh(const core::Box3& box) {
  core::TriMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(core::Vec3((i & 1 ? box.max : box.min).x(), (i & 2 ? box.max : box.min).y(),
                                       (i & 4 ? box.max : box.min).z())
                                .cast<float>());
  }
  for (const auto& [a, b, c, d] : std::vector<std::array<uint32_t, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

/// A world of boxes: its meshes, and an exact ray caster that knows nothing of triangles.
struct BoxWorld {
  scenes::SceneSpec scene;
  std::vector<core::Box3> boxes;

  void Add(const core::Vec3& min, const core::Vec3& max, bool is_object = false) {
    boxes.push_back({min, max});
    scenes::ScenePart part;
    part.name = is_object ? "object" : "other";
    part.mesh = BoxMesh(boxes.back());
    part.is_object = is_object;
    scene.parts.push_back(part);
    scene.bounds.Extend(min);
    scene.bounds.Extend(max);
    if (is_object) scene.object_box = boxes.back().Inflated(0.2);
  }

  float RangeOf(const core::Ray& ray, float max_range_m) const {
    float nearest = -1.0f;
    for (const core::Box3& box : boxes) {
      double enter = -1e30, leave = 1e30;
      for (int a = 0; a < 3; ++a) {
        const double inverse = 1.0 / ray.direction[a];
        const double t0 = (box.min[a] - ray.origin[a]) * inverse, t1 = (box.max[a] - ray.origin[a]) * inverse;
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
      }
      if (enter > leave || enter <= 0.0 || enter > max_range_m) continue;
      if (nearest < 0.0f || enter < nearest) nearest = static_cast<float>(enter);
    }
    return nearest;
  }
  experiments::CastRays Caster() const {
    return [this](std::span<const core::Ray> rays, float max_range_m, uint64_t, std::span<float> range_m) {
      for (size_t i = 0; i < rays.size(); ++i) range_m[i] = RangeOf(rays[i], max_range_m);
    };
  }
  /// Truth of the one object box; parts are its faces: -x +x -y +y -z +z.
  scenes::GroundTruth Truth(double spacing) const {
    scenes::GroundTruth truth;
    truth.part_names = {"-x", "+x", "-y", "+y", "-z", "+z"};
    for (size_t k = 0; k < boxes.size(); ++k) {
      if (!scene.parts[k].is_object) continue;
      for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
        const core::Vec3 size = boxes[k].Size();
        for (double a = 0.5 * spacing; a < size[u]; a += spacing) {
          for (double b = 0.5 * spacing; b < size[v]; b += spacing) {
            core::Vec3 p = boxes[k].min;
            p[axis] = face % 2 == 0 ? boxes[k].min[axis] : boxes[k].max[axis];
            p[u] += a;
            p[v] += b;
            truth.points.push_back(p.cast<float>());
            truth.normals.push_back(((face % 2 == 0 ? -1.0 : 1.0) * core::Vec3::Unit(axis)).cast<float>());
            truth.part.push_back(static_cast<uint16_t>(face));
          }
        }
      }
    }
    return truth;
  }
};

inline robots::RobotSpec TestRobot() {
  robots::RobotSpec robot;
  robot.T_base_lidar = core::MakePose(core::Mat3::Identity(), core::Vec3(0.1, 0.0, 0.3));
  return robot;
}

inline core::LidarModel TestLidar() {
  core::LidarModel lidar = core::FindLidarModel("vlp16");
  lidar.columns = 360;
  return lidar;
}

/// Ground of 6 x 6 m with a box to be mapped and a wall that hides one side of it.
inline BoxWorld SmallWorld() {
  BoxWorld world;
  world.Add({-3, -3, -0.5}, {3, 3, 0});
  world.Add({-0.3, -0.5, 0}, {0.5, 0.5, 1.6}, true);
  world.Add({0.9, -0.6, 0}, {1.0, 0.9, 2.0});
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-2.0, 0.0, 0.0}, 0.0);
  return world;
}

}  // namespace atlas::tests
