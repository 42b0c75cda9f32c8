// A camera that follows the robot, with the object behind it, and moves as a person would carry it.
#pragma once

#include "scenes/scene_spec.h"
#include "sim/render/scene_renderer.h"
#include "sim/sensors/raycaster.h"

namespace atlas::experiments {

class FollowCamera {
 public:
  /// `scene` keeps the camera out of walls and under roofs; it outlives the camera.
  FollowCamera(const scenes::SceneSpec& spec, const sim::Raycaster& scene);

  /// Moves on by `dt_s` of video time with the robot at `p_base_map`. The first call jumps there.
  sim::RenderCamera Advance(const core::Vec3& p_base_map, double dt_s);

 private:
  core::Vec3 FreeEye(const core::Vec3& from, const core::Vec3& eye) const;

  const sim::Raycaster& scene_;
  core::Vec3 object_center_;
  double object_radius_m_;
  bool started_ = false;
  double bearing_rad_ = 0.0;
  core::Vec3 eye_ = core::Vec3::Zero(), target_ = core::Vec3::Zero();
};

}  // namespace atlas::experiments
