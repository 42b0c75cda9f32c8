// The robot under physics in its scene. Frame: map. One step lasts kStep; a controller acts between Begin and
// Finish, where kinematics and bias forces are those of the present state.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/mesh.h"
#include "robots/robot_spec.h"
#include "scenes/scene_spec.h"
#include "sim/world/leg_kinematics.h"
#include "sim/world/robot_state.h"

namespace atlas::sim {

/// Largest normal force that static geometry put on each kind of link in the last step.
struct LinkContacts {
  double body_n = 0.0;  ///< base, hips, thighs
  double shank_n = 0.0;
  std::array<double, kLegs> foot_n{};
};

class World : public Dynamics {
 public:
  static constexpr double kStepS = 0.002;
  static constexpr double kTorqueLimitNm = 40.0;

  /// @throws InputError when the model does not compile or lacks a joint, site or foot.
  World(const scenes::SceneSpec& scene, const robots::RobotSpec& robot);
  ~World() override;

  /// Puts the robot at rest with base pose `T_map_base` and joint angles HAA HFE KFE of LF RF LH RH.
  void Place(const core::Pose& T_map_base, const Vec12& joints);
  void BeginStep();
  void FinishStep(const Vec12& torque_nm);

  const RobotState& state() const;
  const LinkContacts& contacts() const;
  Vec18 GeneralisedForce(const Vec18& qdd) const override;
  const LegGeometry& leg(int i) const;
  double time_s() const;
  /// The state ran out of numbers (an exploded contact): treat as a fall.
  bool Broken() const;

  /// Highest static surface at or below `p_map`, by a vertical ray; a point within a solid gives p_map.z.
  std::optional<double> GroundBelow(const core::Vec3& p_map) const;

  core::Pose T_map_base() const;
  std::vector<double> qpos() const;
  /// Visible surface of each rigid body of the robot (the LiDAR itself left out) in its own frame.
  const std::vector<core::TriMesh>& body_meshes() const;
  void BodyPoses(std::vector<core::Pose>* T_map_body) const;

  /// A constant force on the base (map frame) until changed; for tests of robustness.
  void PushBase(const core::Vec3& force_n);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atlas::sim
