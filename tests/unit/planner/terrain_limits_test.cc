// What planning takes for walkable is what the robot can walk.
#include <gtest/gtest.h>

#include "mapping/terrain/elevation_map.h"
#include "robots/robot_spec.h"

namespace atlas::planner {
namespace {

TEST(TerrainLimits, TheDefaultStepIsOneThatTheRobotCanClimb) {
  EXPECT_LE(mapping::TerrainParams{}.critical_step_m, robots::RobotSpec{}.max_step_m);
}

}  // namespace
}  // namespace atlas::planner
