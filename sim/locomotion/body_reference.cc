#include "sim/locomotion/body_reference.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kPlaneTauS = 0.08;
constexpr double kSlopeGain = 0.7;  ///< slopes follow slower than the height
constexpr double kSlopeAlignment = 0.9;
constexpr double kLongestLegM = 0.505;  ///< from the hip's axis to the foot
constexpr double kCapTauS = 0.06;

}  // namespace

void BodyReference::UpdatePlane(const std::array<Vec3, kLegs>& ground, const RobotState& state, double dt_s) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vec3 rhs = Vec3::Zero();
  for (const Vec3& p : ground) {
    const Vec3 row(1.0, p.x() - state.p_base.x(), p.y() - state.p_base.y());
    normal += row * row.transpose();
    rhs += row * p.z();
  }
  const Vec3 fit = normal.ldlt().solve(rhs);
  if (!started_) {
    started_ = true;
    plane_.origin = {state.p_base.x(), state.p_base.y(), fit[0]};
    plane_.slope = fit.tail<2>();
    return;
  }
  const double blend = dt_s / (kPlaneTauS + dt_s);
  double z = plane_.origin.z() + plane_.slope.dot(state.v_base.head<2>()) * dt_s;
  z += blend * (fit[0] - z);
  plane_.origin = {state.p_base.x(), state.p_base.y(), z};
  plane_.slope += blend * kSlopeGain * (fit.tail<2>() - plane_.slope);
}

BasePosture BodyReference::Posture(const std::array<Vec3, kLegs>& feet, const RobotState& state,
                                   double yaw_rad, const BodyRoll& roll, double dt_s) {
  const double yaw_now = core::YawOf(state.R_base);
  const Vec2 ahead(std::cos(yaw_now), std::sin(yaw_now)), left(-ahead.y(), ahead.x());
  const double alignment = kSlopeAlignment * (1.0 - roll.level);
  BasePosture posture;
  posture.R_base =
      core::RotationFromYawPitchRoll(yaw_rad, -alignment * std::atan(plane_.slope.dot(ahead)),
                                     alignment * std::atan(plane_.slope.dot(left)) + roll.roll_rad);

  double cap = 1e3;
  for (int i = 0; i < kLegs; ++i) {
    const LegGeometry& leg = legs_[i];
    const Vec3 hip = state.R_base * (leg.haa_base + Vec3(leg.hfe_forward_m, leg.lateral_m, 0.0));
    const double sideways = std::min((feet[i] - state.p_base - hip).head<2>().norm(), 0.3);
    cap = std::min(cap, feet[i].z() + std::sqrt(kLongestLegM * kLongestLegM - sideways * sideways) - hip.z());
  }
  height_cap_ =
      height_cap_ > 100.0 ? cap : height_cap_ + std::min(1.0, dt_s / kCapTauS) * (cap - height_cap_);
  posture.z = std::min(plane_.origin.z() + height_m_, height_cap_);
  posture.v_z = plane_.slope.dot(state.v_base.head<2>());
  return posture;
}

}  // namespace atlas::sim
