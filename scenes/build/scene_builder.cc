#include "scenes/build/scene_builder.h"

#include <utility>

#include "scenes/build/convex_hull.h"

namespace atlas::scenes {

using core::Pose;
using core::Vec3;

ScenePart& SceneBuilder::PartOf(const Paint& paint) {
  for (ScenePart& part : scene_.parts) {
    if (part.name == paint.name && part.label == paint.label && part.is_object == paint.is_object &&
        part.ray_transmission == paint.ray_transmission) {
      return part;
    }
  }
  scene_.parts.emplace_back();
  ScenePart& part = scene_.parts.back();
  part.name = paint.name;
  part.label = paint.label;
  part.is_object = paint.is_object;
  part.ray_transmission = paint.ray_transmission;
  return part;
}

void SceneBuilder::Box(const Paint& paint, const Vec3& half_size, const Pose& T_map_box) {
  const core::TriMesh mesh = MakeBox(half_size, T_map_box);
  Visual(paint, mesh);
  if (mesh.Bounds().min.z() < reach_z_) Collide(paint, {BoxShape{half_size}, T_map_box});
}

void SceneBuilder::Box(const Paint& paint, const Vec3& min, const Vec3& max, Physics physics) {
  const Vec3 half_size = 0.5 * (max - min);
  const Pose T_map_box = At(0.5 * (min + max));
  if (physics == Physics::kSolid) {
    Box(paint, half_size, T_map_box);
  } else {
    Visual(paint, MakeBox(half_size, T_map_box));
  }
}

void SceneBuilder::Cylinder(const Paint& paint, const Vec3& a, const Vec3& b, double radius, int corners) {
  const Pose T_map_cylinder = PoseBetween(a, b);
  const double half_length = 0.5 * (b - a).norm();
  const core::TriMesh mesh = MakeCylinder(radius, half_length, T_map_cylinder, corners);
  Visual(paint, mesh);
  if (mesh.Bounds().min.z() < reach_z_) {
    Collide(paint, {CylinderShape{radius, half_length}, T_map_cylinder});
  }
}

void SceneBuilder::Tube(const Paint& paint, const std::vector<Vec3>& path, double radius, int corners) {
  Visual(paint, MakeTube(path, radius, corners));
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    if (std::min(path[i].z(), path[i + 1].z()) - radius >= reach_z_) continue;
    const double half_length = 0.5 * (path[i + 1] - path[i]).norm();
    Collide(paint, {CapsuleShape{radius, half_length}, PoseBetween(path[i], path[i + 1])});
  }
}

void SceneBuilder::Convex(const Paint& paint, const core::TriMesh& mesh) {
  Visual(paint, mesh);
  if (mesh.Bounds().min.z() < reach_z_)
    Collide(paint, {HullShape{ConvexHull(mesh.vertices)}, Pose::Identity()});
}

void SceneBuilder::Visual(const Paint& paint, const core::TriMesh& mesh) {
  PartOf(paint).mesh.Append(mesh);
}

void SceneBuilder::Collide(const Paint& paint, CollisionShape shape) {
  PartOf(paint).collision.push_back(std::move(shape));
}

SceneSpec SceneBuilder::Finish(const core::Vec2& spawn_xy, double spawn_yaw_rad) {
  scene_.T_map_spawn = core::PoseFromXyzYaw(Vec3(spawn_xy.x(), spawn_xy.y(), 0.0), spawn_yaw_rad);
  core::Box3 object;
  for (const ScenePart& part : scene_.parts) {
    const core::Box3 box = part.mesh.Bounds();
    scene_.bounds.Extend(box.min);
    scene_.bounds.Extend(box.max);
    if (!part.is_object) continue;
    object.Extend(box.min);
    object.Extend(box.max);
  }
  constexpr double kMargin_m = 0.15, kAboveGround_m = 0.04;
  scene_.object_box = object.Inflated(kMargin_m);
  scene_.object_box.min.z() = kAboveGround_m;
  return std::move(scene_);
}

SceneSpec SceneBuilder::FinishSpace(const core::Vec2& spawn_xy, double spawn_yaw_rad,
                                    double truth_spacing_m) {
  SceneSpec scene = Finish(spawn_xy, spawn_yaw_rad);
  scene.is_space = true;
  scene.truth_spacing_m = truth_spacing_m;
  constexpr double kBelowGround_m = 0.15;
  double lowest = 0.0;
  for (const ScenePart& part : scene.parts) {
    for (const CollisionShape& shape : part.collision) {
      const auto* grid = std::get_if<HeightGridShape>(&shape.shape);
      if (grid == nullptr) continue;
      for (float height : grid->height_m) lowest = std::min(lowest, static_cast<double>(height));
    }
  }
  scene.object_box.min.z() = lowest - kBelowGround_m;
  return scene;
}

Pose SideOutline(double y) {
  core::Mat3 R;
  R.col(0) = Vec3::UnitX();
  R.col(1) = Vec3::UnitZ();
  R.col(2) = -Vec3::UnitY();
  return core::MakePose(R, Vec3(0.0, y, 0.0));
}

}  // namespace atlas::scenes
