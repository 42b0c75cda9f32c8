// Joint torques that give the base and the swinging feet wanted accelerations while standing feet do not
// slip.
#pragma once

#include <array>

#include "sim/world/robot_state.h"

namespace atlas::sim {

struct LegTask {
  bool stance = true;
  core::Vec3 acceleration = core::Vec3::Zero();  ///< of the foot, map; stance legs are damped instead
  double force_scale = 1.0;                      ///< of the largest force; ramps a foot in and out of support
};

struct WholeBodyTask {
  Vec6 base_acceleration = Vec6::Zero();  ///< linear in map, angular in base
  std::array<LegTask, kLegs> leg;
};

/// Stance feet share the base's six equations of motion in a box-constrained least-squares problem over four
/// friction generators a foot (contact normal: the vertical); joint torques follow by inverse dynamics.
class WholeBodyController {
 public:
  Vec12 Torques(const WholeBodyTask& task, const RobotState& state, const Dynamics& dynamics, double dt_s);

 private:
  struct Jacobian {
    Mat36 base;
    core::Mat3 leg;
  };
  Vec18 Accelerations(const WholeBodyTask& task, const RobotState& state, double dt_s);

  bool started_ = false;
  std::array<Jacobian, kLegs> previous_;
};

}  // namespace atlas::sim
