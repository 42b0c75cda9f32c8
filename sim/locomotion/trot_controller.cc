#include "sim/locomotion/trot_controller.h"

namespace atlas::sim {
namespace {

using core::Mat3;
using core::Vec2;
using core::Vec3;

constexpr double kLinearAcceleration = 1.5, kYawAcceleration = 4.0;
constexpr double kMaxYawLead = 0.4;  ///< of the reference over the base
constexpr double kMaxLeadTrot = 0.06, kMaxLeadStand = 0.15;
constexpr double kVelocityIntegral = 0.6, kMaxVelocityIntegral = 0.2, kIntegralDecay = 2.0;
constexpr double kStandAfterS = 0.55, kStandAnywayAfterS = 3.0;
constexpr double kStandSpeedMps = 0.12, kStandFeetM = 0.08;
constexpr double kCaptureM = 0.14;   ///< a capture point farther out needs a step
constexpr double kLiftWindow = 0.3;  ///< share of a scheduled swing in which a leg lifts

struct Gains {
  double p, d;
};
constexpr Gains kHeight = {150.0, 22.0}, kTilt = {200.0, 26.0}, kYaw = {100.0, 20.0};
constexpr Gains kPlanarTrot = {10.0, 10.0}, kPlanarStand = {60.0, 14.0};
constexpr double kMaxPlanar = 5.0, kMaxDown = 8.0, kMaxUp = 12.0, kMaxAngular = 60.0;
constexpr double kLoadingS = 0.03;  ///< in and out of support

double Toward(double from, double to, double limit) {
  return from + std::clamp(to - from, -limit, limit);
}

Vec2 Limited(const Vec2& v, double limit) {
  const double size = v.norm();
  return size > limit ? Vec2(v * (limit / size)) : v;
}

}  // namespace

TrotController::TrotController(const std::array<LegGeometry, kLegs>& legs, double height_m,
                               TerrainSampler* terrain)
    : terrain_(terrain), reference_(legs, height_m) {
  for (size_t i = 0; i < kLegs; ++i) {
    legs_[i] = LegCycle(legs[i].foot_radius_m, -legs[i].fore);
    nominal_base_[i] = Vec2(legs[i].fore * kNominalFootX, legs[i].side * kNominalFootY);
  }
}

Vec12 TrotController::Update(const RobotState& state, const Dynamics& dynamics, double dt_s) {
  news_.clear();
  if (!started_) Start(state);
  ShapeCommand(state, dt_s);
  SwitchMode(state);
  if (mode_ == Mode::kTrot) AdvanceClock(dt_s);
  StepLegs(state, dt_s);

  std::array<Vec3, kLegs> ground, feet;
  for (int i = 0; i < kLegs; ++i) {
    ground[i] = legs_[i].Ground();
    feet[i] = legs_[i].Foot(state.leg[i]);
  }
  reference_.UpdatePlane(ground, state, dt_s);
  terrain_->SetPlane(reference_.plane());
  const BasePosture posture = reference_.Posture(feet, state, yaw_ref_, roll_, dt_s);

  WholeBodyTask task;
  task.base_acceleration = BaseAcceleration(state, posture);
  for (int i = 0; i < kLegs; ++i) {
    task.leg[i].stance = !legs_[i].swing();
    if (legs_[i].swing()) task.leg[i].acceleration = legs_[i].Acceleration(state.leg[i]);
    task.leg[i].force_scale = ForceScale(i);
  }
  return whole_body_.Torques(task, state, dynamics, dt_s);
}

void TrotController::Start(const RobotState& state) {
  started_ = true;
  yaw_ref_ = core::YawOf(state.R_base);
  for (int i = 0; i < kLegs; ++i) legs_[i].StandAt(state.leg[i]);
  p_ref_ = FeetCentre(state);
}

void TrotController::ShapeCommand(const RobotState& state, double dt_s) {
  const double linear = kLinearAcceleration * dt_s;
  shaped_.x() = Toward(shaped_.x(), command_.forward_mps, linear);
  shaped_.y() = Toward(shaped_.y(), command_.lateral_mps, linear);
  shaped_.z() = Toward(shaped_.z(), command_.yaw_radps, kYawAcceleration * dt_s);
  zero_command_s_ = command_.zero() ? zero_command_s_ + dt_s : 0.0;

  const double yaw = core::YawOf(state.R_base);
  const double lead = core::WrapAngle(yaw_ref_ + shaped_.z() * dt_s - yaw);
  yaw_ref_ = yaw + std::clamp(lead, -kMaxYawLead, kMaxYawLead);

  const Eigen::Rotation2Dd R_heading(yaw);
  if (mode_ == Mode::kTrot && !command_.zero()) {
    const Vec2 v_heading = R_heading.inverse() * Vec2(state.v_base.head<2>());
    v_integral_ += kVelocityIntegral * dt_s * (shaped_.head<2>() - v_heading);
    v_integral_ = v_integral_.cwiseMax(-kMaxVelocityIntegral).cwiseMin(kMaxVelocityIntegral);
  } else {
    v_integral_ *= 1.0 - kIntegralDecay * dt_s;
  }
  p_ref_ += R_heading * Vec2(shaped_.head<2>()) * dt_s;
  v_command_ = R_heading * Vec2(shaped_.head<2>() + v_integral_);
  const Vec2 p_base = state.p_base.head<2>();
  p_ref_ = p_base + Limited(p_ref_ - p_base, mode_ == Mode::kTrot ? kMaxLeadTrot : kMaxLeadStand);
}

Vec2 TrotController::FeetCentre(const RobotState& state) const {
  Vec2 centre = Vec2::Zero();
  for (const LegState& leg : state.leg) centre += 0.25 * leg.p_foot.head<2>();
  return centre;
}

void TrotController::SwitchMode(const RobotState& state) {
  const Vec2 p_base = state.p_base.head<2>(), v_base = state.v_base.head<2>();
  if (mode_ == Mode::kStand) {
    const double height = std::max(0.2, state.p_base.z() - plane().origin.z());
    const Vec2 capture = state.p_com.head<2>() + v_base * std::sqrt(height / kGravity);
    const bool rolling = std::abs(roll_.roll_rad) > 0.02;
    const bool falling = !rolling && (capture - FeetCentre(state)).norm() > kCaptureM;
    if (command_.zero() && !falling) return;
    mode_ = Mode::kTrot;
    gait_.Restart();
    p_ref_ = p_base;
    if (falling) zero_command_s_ = 0.0;
    return;
  }
  bool feet_placed = true, all_stand = true;
  const Eigen::Rotation2Dd R_heading(core::YawOf(state.R_base));
  for (int i = 0; i < kLegs; ++i) {
    const Vec2 nominal = p_base + R_heading * nominal_base_[i];
    feet_placed = feet_placed && (state.leg[i].p_foot.head<2>() - nominal).norm() < kStandFeetM;
    all_stand = all_stand && !legs_[i].swing();
  }
  const bool placed = feet_placed || zero_command_s_ > kStandAnywayAfterS;
  if (command_.zero() && zero_command_s_ > kStandAfterS && all_stand && v_base.norm() < kStandSpeedMps &&
      placed) {
    mode_ = Mode::kStand;
    p_ref_ = FeetCentre(state);
  }
}

/// The clock waits while a leg is late and the other pair is about to lift.
void TrotController::AdvanceClock(double dt_s) {
  bool late = false, about_to_lift = false;
  for (int i = 0; i < kLegs; ++i) {
    const bool stance_phase = !gait_.InSwing(i);
    late = late || (legs_[i].swing() && stance_phase);
    about_to_lift =
        about_to_lift || (!legs_[i].swing() && stance_phase && gait_.StanceLeftS(i) < 1.01 * dt_s);
  }
  if (!(late && about_to_lift)) gait_.Advance(dt_s);
}

void TrotController::StepLegs(const RobotState& state, double dt_s) {
  const double yaw = core::YawOf(state.R_base);
  for (int i = 0; i < kLegs; ++i) {
    LegCycle& leg = legs_[i];
    const LegState& measured = state.leg[i];
    if (!leg.swing()) {
      leg.Support(measured, dt_s);
      const bool due = mode_ == Mode::kTrot && gait_.InSwing(i) && gait_.SwingProgress(i) < kLiftWindow;
      if (due) leg.LiftOff(measured);
    }
    if (!leg.swing()) continue;
    const bool aimed = leg.aims();
    if (aimed) leg.Aim(FootholdFor(i, state), yaw, *terrain_);
    leg.Advance(dt_s);
    if (aimed && !leg.aims()) news_.push_back({FootEvent::kCommitted, leg.target(), measured.p_foot});
    if (leg.TouchesDown(measured)) {
      if (leg.aims()) news_.push_back({FootEvent::kCommitted, leg.target(), measured.p_foot});
      leg.Land(measured);
      news_.push_back({FootEvent::kTouchdown, leg.target(), measured.p_foot});
    }
  }
}

Vec2 TrotController::FootholdFor(int i, const RobotState& state) const {
  FootholdInput in;
  in.p_base = state.p_base.head<2>();
  in.v_base = state.v_base.head<2>();
  in.v_command = v_command_;
  in.com_offset = (state.p_com - state.p_base).head<2>();
  in.yaw_rad = core::YawOf(state.R_base);
  in.yaw_rate_command = shaped_.z();
  in.height_m = state.p_base.z() - plane().origin.z();
  in.swing_left_s = legs_[i].swing_left_s();
  in.nominal_base = nominal_base_[i];
  return NominalFoothold(in);
}

Vec6 TrotController::BaseAcceleration(const RobotState& state, const BasePosture& posture) const {
  const bool trot = mode_ == Mode::kTrot;
  const Gains planar = trot ? kPlanarTrot : kPlanarStand;
  const Vec2 p = trot ? state.p_base.head<2>() : state.p_com.head<2>();
  Vec3 linear;
  linear.head<2>() = planar.p * (p_ref_ - p) + planar.d * (v_command_ - state.v_base.head<2>());
  linear.z() = kHeight.p * (posture.z - state.p_base.z()) + kHeight.d * (posture.v_z - state.v_base.z());
  linear.head<2>() = linear.head<2>().cwiseMax(-kMaxPlanar).cwiseMin(kMaxPlanar);
  linear.z() = std::clamp(linear.z(), -kMaxDown, kMaxUp);

  const Eigen::AngleAxisd error(posture.R_base * state.R_base.transpose());
  const Vec3 e_local = state.R_base.transpose() * (error.axis() * error.angle());
  const Vec3 w_ref = Vec3(0.0, 0.0, shaped_.z()) + posture.R_base * Vec3(roll_.rate_radps, 0.0, 0.0);
  const Vec3 e_rate = state.R_base.transpose() * w_ref - state.w_base_local;
  Vec3 angular(kTilt.p * e_local.x() + kTilt.d * e_rate.x(), kTilt.p * e_local.y() + kTilt.d * e_rate.y(),
               kYaw.p * e_local.z() + kYaw.d * e_rate.z());
  angular = angular.cwiseMax(-kMaxAngular).cwiseMin(kMaxAngular);
  return (Vec6() << linear, angular).finished();
}

double TrotController::ForceScale(int i) const {
  if (mode_ != Mode::kTrot) return 1.0;
  double scale = std::min(1.0, 0.25 + legs_[i].stance_s() / kLoadingS);
  bool any_late = false;
  for (const LegCycle& leg : legs_) any_late = any_late || (leg.swing() && leg.late());
  if (!any_late && !gait_.InSwing(i)) {
    const double left_s = gait_.StanceLeftS(i);
    if (left_s < kLoadingS) scale = std::min(scale, 0.15 + left_s / kLoadingS);
  }
  return scale;
}

}  // namespace atlas::sim
