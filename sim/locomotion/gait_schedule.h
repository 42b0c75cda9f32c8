// The clock of a trot: diagonal pairs swing in turn.
#pragma once

#include <array>

namespace atlas::sim {

class GaitSchedule {
 public:
  static constexpr double kPeriodS = 0.50;
  static constexpr double kDuty = 0.56;  ///< share of the period in stance
  static constexpr double kSwingS = kPeriodS * (1.0 - kDuty);
  static constexpr double kStanceS = kPeriodS * kDuty;

  /// Puts the clock where the second pair (RF, LH) is about to lift.
  void Restart() { phase_ = kDuty - kOffset[1] + 0.001; }
  void Advance(double dt_s);

  /// Of leg i in [0, 1): stance below kDuty, swing from there.
  double LegPhase(int i) const;
  bool InSwing(int i) const { return LegPhase(i) >= kDuty; }
  /// Share of the swing that has passed. @pre InSwing(i)
  double SwingProgress(int i) const { return (LegPhase(i) - kDuty) / (1.0 - kDuty); }
  /// @pre !InSwing(i)
  double StanceLeftS(int i) const { return (kDuty - LegPhase(i)) * kPeriodS; }

 private:
  static constexpr std::array<double, 4> kOffset = {0.0, 0.5, 0.5, 0.0};
  double phase_ = 0.0;
};

}  // namespace atlas::sim
