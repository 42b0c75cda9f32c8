// The gait under physics without the rest of the simulator, for tests that push it or drive it by velocity.
#pragma once

#include "robots/robot_spec.h"
#include "sim/locomotion/locomotion.h"
#include "sim/locomotion/safety_monitor.h"
#include "sim/locomotion/trot_controller.h"
#include "sim/world/world.h"

namespace atlas::sim::test {

class WalkingRobot {
 public:
  explicit WalkingRobot(const scenes::SceneSpec& scene)
      : WalkingRobot(scene, robots::LoadRobot("quadruped")) {}
  WalkingRobot(const scenes::SceneSpec& scene, const robots::RobotSpec& spec)
      : world(scene, spec),
        terrain([this](const core::Vec3& p) { return world.GroundBelow(p); }),
        controller({world.leg(0), world.leg(1), world.leg(2), world.leg(3)}, spec.stance_height_m, &terrain) {
    terrain.SetSource(GroundSource::kTruth);
    const core::Vec3 up(0.0, 0.0, spec.stance_height_m + 0.003);
    world.Place(scene.T_map_spawn * Eigen::Translation3d(up), NominalPosture(world, spec.stance_height_m));
  }

  /// Runs for `duration_s`; `each` sees the state at every step. Returns false after a fall.
  template <typename Each>
  bool Run(double duration_s, const VelocityCommand& command, const Each& each) {
    controller.SetCommand(command);
    for (const double end = world.time_s() + duration_s; world.time_s() < end && !monitor.fallen();) {
      world.BeginStep();
      each(world.state());
      world.FinishStep(controller.Update(world.state(), world, World::kStepS));
      monitor.OnStep(world, controller);
    }
    return !monitor.fallen();
  }
  bool Run(double duration_s, const VelocityCommand& command) {
    return Run(duration_s, command, [](const RobotState&) {});
  }

  /// Walks along x at `speed`, steering back to y = 0, until `x` is reached. False on a fall or when too
  /// late.
  bool WalkTo(double x, double speed) {
    const double limit = world.time_s() + 2.0 * std::abs(x) / speed + 5.0;
    while (world.state().p_base.x() < x && world.time_s() < limit) {
      const double lateral = std::clamp(-0.8 * world.state().p_base.y(), -0.15, 0.15);
      const double yaw = std::clamp(-1.5 * core::YawOf(world.state().R_base), -0.5, 0.5);
      if (!Run(0.1, {speed, lateral, yaw})) return false;
    }
    return world.state().p_base.x() >= x;
  }

  World world;
  TerrainSampler terrain;
  TrotController controller;
  SafetyMonitor monitor;
};

}  // namespace atlas::sim::test
