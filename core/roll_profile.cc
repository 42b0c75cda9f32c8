#include "core/roll_profile.h"

#include <algorithm>
#include <cmath>

#include "core/geometry.h"

namespace atlas::core {
namespace {

constexpr double kEase_s = 0.3;

}  // namespace

RollProfile::State RollProfile::At(double time_s) const {
  const double t = std::clamp(time_s, 0.0, period_s_);
  const double ease = std::min(kEase_s, 0.25 * period_s_);
  const double speed = 2.0 * kPi / (period_s_ - ease);  // trapezoid of area 2 pi
  const double to_end = period_s_ - t;
  double phase = speed * (t - 0.5 * ease), rate = speed;
  if (t < ease) {
    rate = speed * t / ease;
    phase = 0.5 * rate * t;
  } else if (to_end < ease) {
    rate = speed * to_end / ease;
    phase = 2.0 * kPi - 0.5 * rate * to_end;
  }
  return {amplitude_rad_ * std::sin(phase), amplitude_rad_ * std::cos(phase) * rate};
}

}  // namespace atlas::core
