#include "sim/world/leg_kinematics.h"

namespace atlas::sim {

core::Vec3 FootPosition(const LegGeometry& leg, const core::Vec3& q) {
  // In the leg's plane, before abduction tilts it: pitch rotates (0, 0, -l) to (-l sin, 0, -l cos).
  const double x = -leg.thigh_m * std::sin(q[1]) - leg.shank_m * std::sin(q[1] + q[2]);
  const double down = leg.thigh_m * std::cos(q[1]) + leg.shank_m * std::cos(q[1] + q[2]);
  const core::Vec3 p_haa(leg.hfe_forward_m + x, leg.lateral_m * std::cos(q[0]) + down * std::sin(q[0]),
                         leg.lateral_m * std::sin(q[0]) - down * std::cos(q[0]));
  return leg.haa_base + p_haa;
}

LegAngles SolveLeg(const LegGeometry& leg, const core::Vec3& p_foot_base) {
  constexpr double kMargin = 1e-4;
  core::Vec3 r = p_foot_base - leg.haa_base;
  r.x() -= leg.hfe_forward_m;

  LegAngles out;
  const double radial = std::hypot(r.y(), r.z());
  const double offset = std::abs(leg.lateral_m);
  out.reachable = radial >= offset;
  const double down = std::sqrt(std::max(radial * radial - offset * offset, 0.0));
  out.q[0] = std::atan2(r.y(), -r.z()) - std::atan2(leg.lateral_m, down);

  const double longest = leg.thigh_m + leg.shank_m - kMargin;
  const double shortest = std::abs(leg.shank_m - leg.thigh_m) + kMargin;
  const double wanted = std::hypot(r.x(), down);
  const double reach = std::clamp(wanted, shortest, longest);
  out.reachable = out.reachable && wanted == reach;
  const double cos_knee = (reach * reach - leg.thigh_m * leg.thigh_m - leg.shank_m * leg.shank_m) /
                          (2.0 * leg.thigh_m * leg.shank_m);
  const double knee = std::acos(std::clamp(cos_knee, -1.0, 1.0));
  const double lead = std::atan2(leg.shank_m * std::sin(knee), leg.thigh_m + leg.shank_m * std::cos(knee));
  out.q[1] = std::atan2(-r.x(), down) + leg.fore * lead;
  out.q[2] = -leg.fore * knee;
  return out;
}

}  // namespace atlas::sim
