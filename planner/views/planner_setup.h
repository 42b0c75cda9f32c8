// What every planner is built from, besides its own parameters.
#pragma once

#include "core/rng.h"
#include "mapping/terrain/elevation_map.h"
#include "planner/gain/sweep_view.h"
#include "planner/goal.h"

namespace atlas::planner {

/// What is expected of the robot.
struct RobotModel {
  SweepSensorModel sensor;
  double speed_mps = 0.5;                               ///< on flat smooth ground
  double half_width_m = 0.33, turning_radius_m = 0.55;  ///< of the footprint

  /// Height of the ground that it stands on, as its own pose tells.
  double GroundUnder(const core::Pose& T_map_base) const {
    return T_map_base.translation().z() - sensor.base_height_m;
  }
};

struct PlannerSetup {
  RobotModel robot;
  Goal goal;
  core::Box3 kept_map;  ///< what the map holds, about the goal: rays are followed in it
  mapping::TerrainParams terrain;
  int threads = 1;
  core::Rng rng{0};
};

}  // namespace atlas::planner
