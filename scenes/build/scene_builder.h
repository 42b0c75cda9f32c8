// Assembles a SceneSpec part by part: each call adds a solid's mesh and the physics shape that equals it.
#pragma once

#include <string>
#include <vector>

#include "scenes/build/shapes.h"
#include "scenes/scene_spec.h"

namespace atlas::scenes {

/// Surfaces wholly above this height over the floor are out of the robot's reach and carry no physics.
constexpr double kReachHeight_m = 1.3;

/// What a solid is. Solids with equal paint join one part.
struct Paint {
  std::string name;
  core::Label label = core::Label::kUnknown;
  bool is_object = false;
  double ray_transmission = 0.0;
};

/// Paint of what is to be mapped.
inline Paint Object(const std::string& name, core::Label label) {
  return {name, label, true};
}

enum class Physics { kSolid, kNone };

class SceneBuilder {
 public:
  /// What is added from now on is reached from a floor at this height; at first z = 0.
  void SetFloor(double floor_z) { reach_z_ = floor_z + kReachHeight_m; }

  /// Axis-aligned box.
  void Box(const Paint& paint, const core::Vec3& min, const core::Vec3& max,
           Physics physics = Physics::kSolid);
  void Box(const Paint& paint, const core::Vec3& half_size, const core::Pose& T_map_box);
  /// Round bar from `a` to `b`.
  void Cylinder(const Paint& paint, const core::Vec3& a, const core::Vec3& b, double radius,
                int corners = 16);
  /// Round bar along a polyline; physics is a capsule a segment.
  void Tube(const Paint& paint, const std::vector<core::Vec3>& path, double radius, int corners = 12);
  /// Physics is the hull of the mesh: @pre it is convex, or its hull is what the robot shall feel.
  void Convex(const Paint& paint, const core::TriMesh& mesh);
  /// Rays only.
  void Visual(const Paint& paint, const core::TriMesh& mesh);
  /// Physics only, felt as part of the solids of this paint.
  void Collide(const Paint& paint, CollisionShape shape);

  /// Sets the bounds, and the object box: the object's parts with a margin of 0.15 m, from 4 cm above the
  /// ground.
  SceneSpec Finish(const core::Vec2& spawn_xy, double spawn_yaw_rad);
  /// As Finish, for a space that the robot moves in: the object box takes in the ground and its relief.
  SceneSpec FinishSpace(const core::Vec2& spawn_xy, double spawn_yaw_rad, double truth_spacing_m);

 private:
  ScenePart& PartOf(const Paint& paint);

  SceneSpec scene_;
  double reach_z_ = kReachHeight_m;
};

/// Axis-aligned pose at `p`.
inline core::Pose At(const core::Vec3& p) {
  return core::MakePose(core::Mat3::Identity(), p);
}

/// The pose whose local x, y are the map's x, z (local z is the map's -y): for outlines drawn from the side.
core::Pose SideOutline(double y = 0.0);

}  // namespace atlas::scenes
