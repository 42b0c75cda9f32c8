// Where the robot has walked since the start, as it knows from its legs and its IMU: with drift.
#pragma once

#include "core/rng.h"
#include "sim/simulator.h"

namespace atlas::sim {

/// The odom frame starts at the spawn pose. Position and heading drift as a random walk over the distance
/// walked; roll, pitch and height are observable and do not.
class Odometry {
 public:
  Odometry(const OdometryParams& params, const core::Pose& T_map_spawn, const core::Pose& T_map_base,
           const core::Rng& rng);

  /// Call at every step with the true pose.
  void Update(const core::Pose& T_map_base);

  const core::Pose& T_odom_base() const { return T_odom_base_; }

 private:
  OdometryParams params_;
  core::Rng drift_rng_;
  core::Pose T_odom_map_;  ///< upright: its drift is what makes the odometry wrong
  core::Pose T_odom_base_;
  core::Vec2 p_last_;
};

}  // namespace atlas::sim
