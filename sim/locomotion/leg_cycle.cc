#include "sim/locomotion/leg_cycle.h"

#include "sim/locomotion/gait_schedule.h"
#include "sim/locomotion/swing_trajectory.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;

constexpr double kContactN = 8.0, kLoadedN = 3.0, kHardContactN = 60.0;
constexpr double kAimUntil = 0.75;        ///< of the swing
constexpr int kSearchPeriodSteps = 10;    ///< 20 ms
constexpr double kSearchMaxMoveM = 0.02;  ///< a nominal that moved farther is searched at once
constexpr double kLateSpeedMps = 0.5;
constexpr double kGiveUp = 2.0;  ///< a swing this many times too long ends
constexpr double kPositionGain = 500.0, kVelocityGain = 40.0;
constexpr double kFeedForward = 0.3, kMaxFeedForward = 60.0;

}  // namespace

bool LegCycle::aims() const {
  return swing_ && (progress() < kAimUntil || swing_s_ < 0.003);
}
double LegCycle::progress() const {
  return swing_s_ / GaitSchedule::kSwingS;
}
double LegCycle::swing_left_s() const {
  return std::max(0.0, GaitSchedule::kSwingS - swing_s_);
}

void LegCycle::StandAt(const LegState& leg) {
  swing_ = late_ = false;
  stance_s_ = 10.0;
  p_target_ = leg.p_foot;
  p_sole_ = leg.p_foot - Vec3(0.0, 0.0, foot_radius_m_);
}

void LegCycle::LiftOff(const LegState& leg) {
  swing_ = true;
  late_ = false;
  swing_s_ = 0.0;
  steps_to_search_ = 0;
  p_start_ = p_ref_ = leg.p_foot;
  v_ref_ = a_ref_ = Vec3::Zero();
}

void LegCycle::Support(const LegState& leg, double dt_s) {
  stance_s_ += dt_s;
  if (leg.normal_force_n > kLoadedN) p_sole_ = leg.p_foot - Vec3(0.0, 0.0, foot_radius_m_);
}

void LegCycle::Land(const LegState& leg) {
  swing_ = false;
  stance_s_ = 0.0;
  p_sole_ = leg.p_foot - Vec3(0.0, 0.0, foot_radius_m_);
}

double LegCycle::HighestOnTheWay(const TerrainSampler& terrain) const {
  constexpr double kSpacingM = 0.03;
  const Vec2 from = p_start_.head<2>(), way = p_target_.head<2>() - from;
  const int count = std::max(2, static_cast<int>(way.norm() / kSpacingM));
  double highest = std::max(p_start_.z(), p_target_.z());
  for (int i = 0; i <= count; ++i) {
    const Vec2 p = from + way * i / count;
    highest = std::max(highest, terrain.At(p.x(), p.y()).z + foot_radius_m_);
  }
  return highest;
}

void LegCycle::Aim(const Vec2& nominal, double yaw_rad, const TerrainSampler& terrain) {
  const bool search = steps_to_search_-- <= 0 || (nominal - searched_).norm() > kSearchMaxMoveM;
  if (search) {
    searched_ = nominal;
    steps_to_search_ = kSearchPeriodSteps;
    foothold_ = SearchFoothold(terrain, nominal, yaw_rad, knee_sign_);
  }
  p_target_.head<2>() = nominal + foothold_.offset;
  p_target_.z() = foothold_.z + foot_radius_m_;
  if (search) highest_z_ = HighestOnTheWay(terrain);
}

void LegCycle::Advance(double dt_s) {
  swing_s_ += dt_s;
  const double s = progress();
  if (s >= 1.0) {
    late_ = true;
    p_ref_.z() -= kLateSpeedMps * dt_s;
    v_ref_ = Vec3(0.0, 0.0, -kLateSpeedMps);
    a_ref_ = Vec3::Zero();
    return;
  }
  const Vec3 p_before = p_ref_, v_before = v_ref_;
  p_ref_ = SwingPoint({p_start_, p_target_, highest_z_}, s);
  v_ref_ = (p_ref_ - p_before) / dt_s;
  a_ref_ = swing_s_ < 2.5 * dt_s ? Vec3(Vec3::Zero()) : Vec3(kFeedForward * (v_ref_ - v_before) / dt_s);
  if (const double size = a_ref_.norm(); size > kMaxFeedForward) a_ref_ *= kMaxFeedForward / size;
}

bool LegCycle::TouchesDown(const LegState& leg) const {
  const double s = progress(), force = leg.normal_force_n;
  return (s > 0.55 && force > kContactN) || (s > 0.35 && force > kHardContactN) || s > kGiveUp;
}

Vec3 LegCycle::Acceleration(const LegState& leg) const {
  return a_ref_ + kPositionGain * (p_ref_ - leg.p_foot) + kVelocityGain * (v_ref_ - leg.v_foot);
}

Vec3 LegCycle::Ground() const {
  if (!swing_) return p_sole_;
  const Vec3 next = p_target_ - Vec3(0.0, 0.0, foot_radius_m_);
  return p_sole_ + std::min(1.0, progress()) * (next - p_sole_);
}

}  // namespace atlas::sim
