// Where the robot believes to be: drifting odometry, corrected by localisation.
#pragma once

#include "core/rng.h"
#include "sim/simulator.h"

namespace atlas::sim {

/// The odom frame starts at the spawn pose. Position and heading drift as a random walk over the distance
/// walked; roll, pitch and height are observable and do not. At the start T_map_odom is exact; the localiser
/// `truth` then knows T_map_base but for white noise, once a period, and `none` leaves T_map_odom alone.
class Odometry {
 public:
  Odometry(const OdometryParams& params, const LocalisationParams& localisation,
           const core::Pose& T_map_spawn, const core::Pose& T_map_base, const core::Rng& rng);

  /// Call at every step with the true pose.
  void Update(double time_s, const core::Pose& T_map_base);

  const core::Pose& T_odom_base() const { return T_odom_base_; }
  const core::Pose& T_map_odom() const { return T_map_odom_; }

 private:
  void Localise(const core::Pose& T_map_base);

  OdometryParams params_;
  LocalisationParams localisation_;
  core::Rng drift_rng_, localisation_rng_;
  core::Pose T_odom_map_;  ///< upright: its drift is what makes the odometry wrong
  core::Pose T_odom_base_, T_map_odom_;
  core::Vec2 p_last_;
  double next_localisation_s_ = 0.0;
};

}  // namespace atlas::sim
