#include "sim/locomotion/swing_trajectory.h"

namespace atlas::sim {
namespace {

constexpr double kStepM = 0.04;        ///< a height difference above this is a step
constexpr double kPressDownM = 0.005;  ///< aimed below the ground, so that contact comes in time

double Quintic(double u) {
  return u * u * u * (10.0 + u * (-15.0 + 6.0 * u));
}
double Cubic(double u) {
  return u * u * (3.0 - 2.0 * u);
}

}  // namespace

core::Vec3 SwingPoint(const SwingShape& shape, double s) {
  const double z0 = shape.p_start.z(), z1 = shape.p_target.z();
  const double highest = std::max({shape.highest_z, z0, z1});
  const bool over_step = highest > std::min(z0, z1) + kStepM;
  const bool level = std::abs(z1 - z0) <= kStepM;

  const double travel_from = over_step ? 0.15 : 0.0, travel_to = over_step ? 0.92 : 1.0;
  const double travelled = Quintic(std::clamp((s - travel_from) / (travel_to - travel_from), 0.0, 1.0));
  const double apex_at = !over_step ? 0.5 : level ? 0.35 : 0.40;
  const double apex = highest + kSwingClearanceM;

  core::Vec3 p = shape.p_start + (shape.p_target - shape.p_start) * travelled;
  p.z() = s < apex_at ? z0 + (apex - z0) * Cubic(s / apex_at)
                      : apex + (z1 - kPressDownM - apex) * Cubic((s - apex_at) / (1.0 - apex_at));
  return p;
}

}  // namespace atlas::sim
