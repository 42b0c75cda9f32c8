// Where the robot has walked since the start, as it knows without looking around: with drift.
#pragma once

#include "core/rng.h"
#include "sim/simulator.h"

namespace atlas::sim {

/// The odom frame starts at the spawn pose. The error is a random walk over the distance walked:
///   legs   position and heading; roll, pitch and height are observable and have none
///   drift  all six axes of T Exp(xi), as a SLAM front end without an IMU has it (thesis 4.7: 1 m after 100
///   m)
///   lidar  the prior of scan matching: as legs, and a share of each way and a turn a metre besides. What the
///   scans make of it comes after the simulator (mapping/slam/lidar_front_end.cc)
class Odometry {
 public:
  Odometry(const OdometryParams& params, const core::Pose& T_map_spawn, const core::Pose& T_map_base,
           const core::Rng& rng);

  /// Call at every step with the true pose.
  void Update(const core::Pose& T_map_base);

  const core::Pose& T_odom_base() const { return T_odom_base_; }

 private:
  /// What the error of a stretch of the walk does to T_odom_map.
  core::Pose LegsError(const core::Pose& T_map_base, const core::Vec2& walked_map);
  core::Pose WanderError(const core::Pose& T_map_base, double walked_m);

  OdometryParams params_;
  core::Rng drift_rng_;
  core::Vec3 bias_m_ = core::Vec3::Zero(), bias_rad_ = core::Vec3::Zero();  ///< drift: a metre walked
  core::Pose T_odom_map_;  ///< its drift is what makes the odometry wrong
  core::Pose T_odom_base_;
  core::Vec2 p_last_;
};

}  // namespace atlas::sim
