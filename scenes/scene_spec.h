// A scene: labelled meshes, where the robot starts, and what is to be mapped.
//
// One set of labelled meshes feeds physics, rays, rendering, labels and the ground-truth cloud, so geometry
// cannot disagree. All coordinates are in the map frame, whose origin lies on the ground.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "core/geometry.h"
#include "core/labels.h"
#include "core/mesh.h"

namespace atlas::scenes {

/// Exact primitives that physics uses where a part is one (half sizes, MuJoCo's convention).
struct BoxShape {
  core::Vec3 half_size;
};
struct CylinderShape {
  double radius, half_length;  ///< along local z
};
struct CapsuleShape {
  double radius, half_length;
};
struct SphereShape {
  double radius;
};
/// Physics collides meshes as convex hulls: this one is convex.
struct HullShape {
  core::TriMesh mesh;
};
/// Regular grid of heights; sample (row, col) stands at origin + spacing * (col, row).
struct HeightGridShape {
  int rows = 0, cols = 0;
  double spacing_m = 0.0;
  core::Vec2 origin = core::Vec2::Zero();
  std::vector<float> height_m;  ///< row-major
};

struct CollisionShape {
  std::variant<BoxShape, CylinderShape, CapsuleShape, SphereShape, HullShape, HeightGridShape> shape;
  core::Pose T_map_shape = core::Pose::Identity();
};

struct ScenePart {
  std::string name;  ///< "tail_boom"; parts of one name are summed in the table of areas
  core::Label label = core::Label::kUnknown;
  core::TriMesh mesh;                     ///< map frame
  std::vector<CollisionShape> collision;  ///< empty: the robot cannot reach it
  bool is_object = false;                 ///< belongs to the object to be mapped (ground truth, coverage)
  /// Share of rays that pass through (a grating as a stochastic screen); 0 = opaque. Feet always meet it.
  double ray_transmission = 0.0;
};

/// A part of a space with a name of its own: boxes of one name are one room.
struct Room {
  std::string name;
  core::Box3 box;
};

struct SceneSpec {
  std::string name;
  std::string doc;  ///< one line
  std::vector<ScenePart> parts;
  core::Pose T_map_spawn = core::Pose::Identity();  ///< the ground point under the base, and the heading
  core::Box3
      object_box;     ///< where the object is (known a priori, thesis 3.6.2); gains and mapping stay in it
  core::Box3 bounds;  ///< everything
  /// The robot moves inside what is to be mapped (rooms, a campus): the object box holds the spawn and all of
  /// the ground, and every part is the object's unless it lies outside.
  bool is_space = false;
  std::vector<Room> rooms = {};   ///< of a space that has such; what separates them are doorways
  double truth_spacing_m = 0.01;  ///< of ground-truth clouds where nothing else is asked for
};

}  // namespace atlas::scenes
