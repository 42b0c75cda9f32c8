// The scanning action as a function of time (thesis 3.6.1).
#pragma once

#include "sim/locomotion/body_reference.h"

namespace atlas::sim {

/// From level to +amplitude, to -amplitude and back to level in `period_s`: a sine whose phase speeds up and
/// slows down over 0.3 s, so that roll, rate and posture join the stand without a jerk. The roll is against
/// gravity.
class RollProfile {
 public:
  RollProfile(double amplitude_rad, double period_s) : amplitude_rad_(amplitude_rad), period_s_(period_s) {}

  double period_s() const { return period_s_; }
  /// Clamped to [0, period_s].
  BodyRoll At(double time_s) const;

 private:
  double amplitude_rad_, period_s_;
};

}  // namespace atlas::sim
