// A trotting gait that balances, steps over terrain, stands, and rolls its body while standing.
//
// Called once a physics step between kinematics and integration. All quantities are in the frame that physics
// runs in; terrain comes through a TerrainSampler, which knows where the robot believes to be.
#pragma once

#include <array>
#include <vector>

#include "sim/locomotion/body_reference.h"
#include "sim/locomotion/gait_schedule.h"
#include "sim/locomotion/leg_cycle.h"
#include "sim/locomotion/whole_body.h"

namespace atlas::sim {

/// In the heading frame of the base.
struct VelocityCommand {
  double forward_mps = 0.0;
  double lateral_mps = 0.0;
  double yaw_radps = 0.0;
  bool zero() const { return std::abs(forward_mps) + std::abs(lateral_mps) + std::abs(yaw_radps) < 1e-3; }
};

class TrotController {
 public:
  static constexpr double kNominalFootX = 0.34, kNominalFootY = 0.235;

  /// `terrain` outlives the controller, which sets its plane.
  TrotController(const std::array<LegGeometry, kLegs>& legs, double height_m, TerrainSampler* terrain);

  void SetCommand(const VelocityCommand& command) { command_ = command; }
  void SetRoll(const BodyRoll& roll) { roll_ = roll; }
  Vec12 Update(const RobotState& state, const Dynamics& dynamics, double dt_s);

  bool standing() const { return mode_ == Mode::kStand; }
  const GroundPlane& plane() const { return reference_.plane(); }
  const LegCycle& leg(int i) const { return legs_[static_cast<size_t>(i)]; }

  enum class FootEvent { kCommitted, kTouchdown };
  struct FootNews {
    FootEvent event;
    core::Vec3 p_target;  ///< foot centre on the planned foothold
    core::Vec3 p_foot;
  };
  /// What happened in the last Update.
  const std::vector<FootNews>& news() const { return news_; }

 private:
  enum class Mode { kStand, kTrot };

  void Start(const RobotState& state);
  void ShapeCommand(const RobotState& state, double dt_s);
  void SwitchMode(const RobotState& state);
  void AdvanceClock(double dt_s);
  void StepLegs(const RobotState& state, double dt_s);
  core::Vec2 FootholdFor(int i, const RobotState& state) const;
  Vec6 BaseAcceleration(const RobotState& state, const BasePosture& posture) const;
  double ForceScale(int i) const;
  core::Vec2 FeetCentre(const RobotState& state) const;

  std::array<LegCycle, kLegs> legs_;
  std::array<core::Vec2, kLegs> nominal_base_;
  TerrainSampler* terrain_;
  GaitSchedule gait_;
  BodyReference reference_;
  WholeBodyController whole_body_;

  bool started_ = false;
  Mode mode_ = Mode::kStand;
  VelocityCommand command_;
  BodyRoll roll_;
  core::Vec3 shaped_ = core::Vec3::Zero();      ///< command after acceleration limits: forward, lateral, yaw
  core::Vec2 v_integral_ = core::Vec2::Zero();  ///< heading frame
  core::Vec2 v_command_ = core::Vec2::Zero();   ///< map frame, integral included
  core::Vec2 p_ref_ = core::Vec2::Zero();
  double yaw_ref_ = 0.0;
  double zero_command_s_ = 10.0;
  std::vector<FootNews> news_;
};

}  // namespace atlas::sim
