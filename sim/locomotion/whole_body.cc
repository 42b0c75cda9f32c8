#include "sim/locomotion/whole_body.h"

#include "sim/locomotion/box_qp.h"

namespace atlas::sim {
namespace {

using core::Mat3;
using core::Vec3;

constexpr double kStanceDamping = 10.0;  ///< 1/s
constexpr double kMaxFootAcceleration = 150.0;
constexpr double kFriction = 0.6 / 1.4142135623730951;  ///< a pyramid within the cone
constexpr double kMaxForceN = 500.0;
constexpr double kRegularisation = 1e-4;
constexpr double kWarmStartN = 20.0;
constexpr int kGenerators = 4;

Vec6 Weights() {
  return (Vec6() << 1.0, 1.0, 1.0, 60.0, 60.0, 5.0).finished();
}

std::array<Vec3, kGenerators> FrictionGenerators() {
  const double c = kFriction;
  return {Vec3(c, c, 1.0), Vec3(c, -c, 1.0), Vec3(-c, c, 1.0), Vec3(-c, -c, 1.0)};
}

/// Contact forces whose sum comes nearest to the wrench that the base needs.
std::array<Vec3, kLegs> DistributeForces(const WholeBodyTask& task, const RobotState& state,
                                         const Vec6& wrench) {
  static const std::array<Vec3, kGenerators> generators = FrictionGenerators();
  static const Vec6 weights = Weights();
  std::array<int, kLegs> stance;
  int count = 0;
  for (int i = 0; i < kLegs; ++i) {
    if (task.leg[i].stance) stance[static_cast<size_t>(count++)] = i;
  }
  std::array<Vec3, kLegs> force;
  force.fill(Vec3::Zero());
  if (count == 0) return force;

  const int n = kGenerators * count;
  Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxQpSize> G(6, n);
  QpVector upper(n);
  for (int k = 0; k < count; ++k) {
    const int i = stance[static_cast<size_t>(k)];
    for (int q = 0; q < kGenerators; ++q) {
      G.col(kGenerators * k + q) = state.leg[i].J_base.transpose() * generators[static_cast<size_t>(q)];
      upper[kGenerators * k + q] = 0.5 * kMaxForceN * task.leg[i].force_scale;
    }
  }
  const auto WG = (weights.asDiagonal() * G).eval();
  QpMatrix H = G.transpose() * WG;
  H.diagonal().array() += kRegularisation * weights.mean();
  const QpVector g = -(WG.transpose() * wrench);
  QpVector x = QpVector::Constant(n, kWarmStartN);
  SolveBoxQp(H, g, QpVector::Zero(n), upper, &x);
  for (int k = 0; k < n; ++k) {
    force[static_cast<size_t>(stance[static_cast<size_t>(k / kGenerators)])] +=
        x[k] * generators[static_cast<size_t>(k % kGenerators)];
  }
  return force;
}

}  // namespace

Vec18 WholeBodyController::Accelerations(const WholeBodyTask& task, const RobotState& state, double dt_s) {
  Vec18 qdd;
  qdd.head<6>() = task.base_acceleration;
  for (int i = 0; i < kLegs; ++i) {
    const LegState& leg = state.leg[i];
    if (!started_) previous_[i] = {leg.J_base, leg.J_leg};
    const Vec3 bias = ((leg.J_base - previous_[i].base) * state.qvel.head<6>() +
                       (leg.J_leg - previous_[i].leg) * state.qvel.segment<3>(6 + 3 * i)) /
                      dt_s;
    previous_[i] = {leg.J_base, leg.J_leg};

    Vec3 wanted = task.leg[i].stance ? Vec3(-kStanceDamping * leg.v_foot) : task.leg[i].acceleration;
    if (const double size = wanted.norm(); size > kMaxFootAcceleration) wanted *= kMaxFootAcceleration / size;
    const Vec3 by_joints = wanted - bias - leg.J_base * task.base_acceleration;
    const Mat3 damped = leg.J_leg * leg.J_leg.transpose() + kRegularisation * Mat3::Identity();
    qdd.segment<3>(6 + 3 * i) = leg.J_leg.transpose() * damped.ldlt().solve(by_joints);
  }
  started_ = true;
  return qdd;
}

Vec12 WholeBodyController::Torques(const WholeBodyTask& task, const RobotState& state,
                                   const Dynamics& dynamics, double dt_s) {
  const Vec18 needed = dynamics.GeneralisedForce(Accelerations(task, state, dt_s));
  const std::array<Vec3, kLegs> force = DistributeForces(task, state, needed.head<6>());
  Vec12 torque = needed.tail<12>();
  for (int i = 0; i < kLegs; ++i) torque.segment<3>(3 * i) -= state.leg[i].J_leg.transpose() * force[i];
  return torque;
}

}  // namespace atlas::sim
