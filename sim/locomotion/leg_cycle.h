// One leg's alternation of stance and swing.
#pragma once

#include "sim/locomotion/foothold.h"
#include "sim/locomotion/terrain_sampler.h"
#include "sim/world/robot_state.h"

namespace atlas::sim {

class LegCycle {
 public:
  LegCycle() = default;
  LegCycle(double foot_radius_m, double knee_sign) : foot_radius_m_(foot_radius_m), knee_sign_(knee_sign) {}

  void StandAt(const LegState& leg);
  void LiftOff(const LegState& leg);
  /// Stance: follows the ground under the loaded foot.
  void Support(const LegState& leg, double dt_s);
  /// Ends the swing where the foot is.
  void Land(const LegState& leg);
  /// Swing: aims at `nominal` plus what the last search of the terrain moved it by.
  void Aim(const core::Vec2& nominal, double yaw_rad, const TerrainSampler& terrain);
  /// Swing: advances the reference. A late foot goes straight down.
  void Advance(double dt_s);
  /// Swing: whether the foot has met the ground, early contact included, or has been late for too long.
  bool TouchesDown(const LegState& leg) const;

  bool swing() const { return swing_; }
  bool late() const { return late_; }
  bool aims() const;  ///< the foothold may still change
  double progress() const;
  double swing_left_s() const;
  double stance_s() const { return stance_s_; }
  /// Acceleration that tracks the reference. @pre swing()
  core::Vec3 Acceleration(const LegState& leg) const;
  /// Foot centre on the foothold, planned or taken.
  core::Vec3 Foot(const LegState& leg) const { return swing_ ? p_target_ : leg.p_foot; }
  const core::Vec3& target() const { return p_target_; }
  /// Ground point for the plane under the robot: slides from the last foothold to the next.
  core::Vec3 Ground() const;

 private:
  double HighestOnTheWay(const TerrainSampler& terrain) const;

  double foot_radius_m_ = 0.03;
  double knee_sign_ = 1.0;
  bool swing_ = false;
  bool late_ = false;
  double swing_s_ = 0.0;
  double stance_s_ = 10.0;
  int steps_to_search_ = 0;
  core::Vec2 searched_ = core::Vec2::Zero();  ///< the nominal foothold of the last search
  Foothold foothold_;
  double highest_z_ = 0.0;
  core::Vec3 p_sole_ = core::Vec3::Zero();  ///< ground point of the last foothold
  core::Vec3 p_start_ = core::Vec3::Zero(), p_target_ = core::Vec3::Zero();
  core::Vec3 p_ref_ = core::Vec3::Zero(), v_ref_ = core::Vec3::Zero(), a_ref_ = core::Vec3::Zero();
};

}  // namespace atlas::sim
