// The error of the proprioceptive state estimate that the gait balances on.
#pragma once

#include "core/rng.h"
#include "sim/world/robot_state.h"

namespace atlas::sim {

/// Band-limited noise (correlation time 0.1 s) on base velocity and attitude, a little white noise on the
/// velocity, and on the height (1 cm at 0.1 m/s); joints and contacts are measured well enough to leave
/// alone.
class StateNoise {
 public:
  StateNoise(double velocity_sigma_mps, double attitude_sigma_rad, const core::Rng& rng)
      : velocity_sigma_(velocity_sigma_mps), attitude_sigma_(attitude_sigma_rad), rng_(rng) {}

  RobotState Observe(const RobotState& truth, double dt_s);

 private:
  core::Vec3 Draw();

  double velocity_sigma_, attitude_sigma_;
  core::Rng rng_;
  core::Vec3 velocity_ = core::Vec3::Zero(), attitude_ = core::Vec3::Zero();  ///< in standard deviations
};

}  // namespace atlas::sim
