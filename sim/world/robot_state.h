// The mechanical state that the gait works on, free of any physics engine.
//
// Legs are ordered LF RF LH RH. Generalised velocity: base linear (map frame), base angular (base frame),
// then HAA HFE KFE of each leg.
#pragma once

#include <array>

#include "core/geometry.h"

namespace atlas::sim {

constexpr int kLegs = 4;
constexpr int kDofs = 18;
constexpr double kGravity = 9.81;

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Vec12 = Eigen::Matrix<double, 12, 1>;
using Vec18 = Eigen::Matrix<double, kDofs, 1>;
using Mat36 = Eigen::Matrix<double, 3, 6>;

struct LegState {
  core::Vec3 p_foot = core::Vec3::Zero();  ///< centre of the foot's sphere, map
  core::Vec3 v_foot = core::Vec3::Zero();
  Mat36 J_base = Mat36::Zero();  ///< v_foot = J_base * qvel[0..6) + J_leg * its three joint rates
  core::Mat3 J_leg = core::Mat3::Zero();
  double normal_force_n = 0.0;  ///< measured in the last step
};

struct RobotState {
  double time_s = 0.0;
  core::Vec3 p_base = core::Vec3::Zero();
  core::Mat3 R_base = core::Mat3::Identity();
  core::Vec3 v_base = core::Vec3::Zero();        ///< map
  core::Vec3 w_base_local = core::Vec3::Zero();  ///< angular velocity in the base frame
  core::Vec3 p_com = core::Vec3::Zero();         ///< of the whole robot
  Vec18 qvel = Vec18::Zero();
  std::array<LegState, kLegs> leg;
};

/// Inverse dynamics without contact: joint and base forces that produce the acceleration `qdd` at the current
/// state.
class Dynamics {
 public:
  virtual ~Dynamics() = default;
  virtual Vec18 GeneralisedForce(const Vec18& qdd) const = 0;
};

}  // namespace atlas::sim
