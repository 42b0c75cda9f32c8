// The ground plane under the robot and the posture of the base above it.
#pragma once

#include <array>

#include "sim/locomotion/terrain_sampler.h"
#include "sim/world/leg_kinematics.h"
#include "sim/world/robot_state.h"

namespace atlas::sim {

/// A roll of the base on top of its posture, for scanning.
struct BodyRoll {
  double roll_rad = 0.0;
  double rate_radps = 0.0;
  double level = 0.0;  ///< 0: posture follows the ground, 1: posture is level, so the roll is against gravity
};

struct BasePosture {
  core::Mat3 R_base = core::Mat3::Identity();
  double z = 0.0;
  double v_z = 0.0;
};

class BodyReference {
 public:
  BodyReference(const std::array<LegGeometry, kLegs>& legs, double height_m)
      : legs_(legs), height_m_(height_m) {}

  /// Follows the least-squares plane of four ground points with a time constant of 0.08 s.
  void UpdatePlane(const std::array<core::Vec3, kLegs>& ground, const RobotState& state, double dt_s);

  /// Pitch and roll take 0.9 of the slope; the height is capped so that every leg stays under 0.505 m.
  /// `feet`: where each foot stands, or will.
  BasePosture Posture(const std::array<core::Vec3, kLegs>& feet, const RobotState& state, double yaw_rad,
                      const BodyRoll& roll, double dt_s);

  const GroundPlane& plane() const { return plane_; }

 private:
  std::array<LegGeometry, kLegs> legs_;
  double height_m_;
  bool started_ = false;
  GroundPlane plane_;  ///< its origin is kept below the base
  double height_cap_ = 1e3;
};

}  // namespace atlas::sim
