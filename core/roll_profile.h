// The scanning action as a function of time (thesis 3.6.1): what the simulator does and the planner predicts.
#pragma once

namespace atlas::core {

/// Roll of the base from level to +amplitude, to -amplitude and back to level in `period_s`: a sine whose
/// phase speeds up and slows down over 0.3 s at its ends, so that roll and rate join the stand without a
/// jerk.
///
///     +A    .-.
///          /   \            roll(t) = A sin(phase(t)), phase' a trapezoid of area 2 pi:
///      0  /     \     /     constant but for its ends, so the roll dwells at +A and -A and
///                \   /      crosses the level fastest.
///     -A          '-'
///
/// @pre amplitude_rad >= 0, period_s > 0.
class RollProfile {
 public:
  struct State {
    double roll_rad = 0.0;
    double rate_radps = 0.0;
  };

  RollProfile(double amplitude_rad, double period_s) : amplitude_rad_(amplitude_rad), period_s_(period_s) {}

  double amplitude_rad() const { return amplitude_rad_; }
  double period_s() const { return period_s_; }
  /// Clamped to [0, period_s].
  State At(double time_s) const;

 private:
  double amplitude_rad_, period_s_;
};

}  // namespace atlas::core
