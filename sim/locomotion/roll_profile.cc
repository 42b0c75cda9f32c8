#include "sim/locomotion/roll_profile.h"

namespace atlas::sim {
namespace {

constexpr double kLevelS = 0.5;

double SmoothStep(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

BodyRoll RollProfile::At(double time_s) const {
  const double t = std::clamp(time_s, 0.0, period_s());
  const core::RollProfile::State roll = roll_.At(t);
  const double to_an_end = std::min(t, period_s() - t);
  return {roll.roll_rad, roll.rate_radps, SmoothStep(to_an_end / std::min(kLevelS, 0.25 * period_s()))};
}

}  // namespace atlas::sim
