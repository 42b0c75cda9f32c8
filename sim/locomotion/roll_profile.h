// The scanning action as the body follows it (thesis 3.6.1).
#pragma once

#include "core/roll_profile.h"
#include "sim/locomotion/body_reference.h"

namespace atlas::sim {

/// core::RollProfile against gravity: the posture leaves the slope of the ground and comes back to it over
/// half a second at the ends.
class RollProfile {
 public:
  RollProfile(double amplitude_rad, double period_s) : roll_(amplitude_rad, period_s) {}

  double period_s() const { return roll_.period_s(); }
  /// Clamped to [0, period_s].
  BodyRoll At(double time_s) const;

 private:
  core::RollProfile roll_;
};

}  // namespace atlas::sim
