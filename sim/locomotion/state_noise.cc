#include "sim/locomotion/state_noise.h"

namespace atlas::sim {
namespace {

constexpr double kCorrelationS = 0.1;
constexpr double kWhiteShare = 0.5;
constexpr double kHeightSigmaM = 0.01, kFullHeightNoiseMps = 0.1;

}  // namespace

core::Vec3 StateNoise::Draw() {
  core::Vec3 v;
  for (int k = 0; k < 3; ++k) v[k] = rng_.Normal();
  return v;
}

RobotState StateNoise::Observe(const RobotState& truth, double dt_s) {
  if (velocity_sigma_ <= 0.0 && attitude_sigma_ <= 0.0) return truth;
  const double keep = std::exp(-dt_s / kCorrelationS), renew = std::sqrt(1.0 - keep * keep);
  velocity_ = keep * velocity_ + renew * Draw();
  attitude_ = keep * attitude_ + renew * Draw();
  RobotState seen = truth;
  seen.v_base += velocity_sigma_ * (velocity_ + kWhiteShare * Draw());
  const core::Vec3 tilt = attitude_sigma_ * attitude_;
  const double angle = tilt.norm();
  if (angle > 1e-12) seen.R_base = Eigen::AngleAxisd(angle, tilt / angle).toRotationMatrix() * truth.R_base;
  seen.p_base.z() += kHeightSigmaM * std::min(1.0, velocity_sigma_ / kFullHeightNoiseMps) * velocity_.z();
  return seen;
}

}  // namespace atlas::sim
