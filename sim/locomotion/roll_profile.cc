#include "sim/locomotion/roll_profile.h"

namespace atlas::sim {
namespace {

constexpr double kEaseS = 0.3;
constexpr double kLevelS = 0.5;

double SmoothStep(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

BodyRoll RollProfile::At(double time_s) const {
  const double t = std::clamp(time_s, 0.0, period_s_);
  const double ease = std::min(kEaseS, 0.25 * period_s_);
  const double speed = 2.0 * core::kPi / (period_s_ - ease);  // trapezoid of area 2 pi
  const double to_end = period_s_ - t;
  double phase, rate;
  if (t < ease) {
    rate = speed * t / ease;
    phase = 0.5 * rate * t;
  } else if (to_end < ease) {
    rate = speed * to_end / ease;
    phase = 2.0 * core::kPi - 0.5 * rate * to_end;
  } else {
    rate = speed;
    phase = speed * (t - 0.5 * ease);
  }
  BodyRoll roll;
  roll.roll_rad = amplitude_rad_ * std::sin(phase);
  roll.rate_radps = amplitude_rad_ * std::cos(phase) * rate;
  roll.level = SmoothStep(std::min(t, to_end) / std::min(kLevelS, 0.25 * period_s_));
  return roll;
}

}  // namespace atlas::sim
