// What the safety counts see where the map is wrong about the ground.
#include <gtest/gtest.h>

#include "locomotion_scenes.h"
#include "walking_robot.h"

namespace atlas::sim {
namespace {

using test::WalkingRobot;

/// The floor ends at x = 1; nothing lies beyond.
scenes::SceneSpec ScarpScene() {
  scenes::SceneSpec scene;
  scene.name = "scarp";
  scene.parts.push_back(test::BoxPart("floor", {4.0, 4.0, 0.25}, test::At(-3.0, 0.0, -0.25)));
  return scene;
}

TEST(Safety, FootholdsBeyondAnEdgeThatTheMapDoesNotHoldAreOffSolidGround) {
  const auto level = [](double, double) { return 0.0; };
  const test::PerceivedTerrain<decltype(level)> map(level, 0.0, 1);
  WalkingRobot robot(ScarpScene());
  robot.terrain.SetSource(GroundSource::kPerceived, &map);
  ASSERT_TRUE(robot.Run(1.0, {0.4, 0.0, 0.0}));
  EXPECT_GT(robot.monitor.counts().footholds, 4);
  EXPECT_EQ(robot.monitor.counts().footholds_off_solid, 0);
  robot.Run(4.0, {0.4, 0.0, 0.0});  // over the edge, and down
  const SafetyCounts& counts = robot.monitor.counts();
  EXPECT_GE(counts.footholds_off_solid, 1);
  EXPECT_LT(counts.footholds_off_solid, counts.footholds);
}

TEST(Safety, FeetDropByAsMuchAsTheMapHoldsTheGroundTooHigh) {
  const auto drop_of = [](double too_high_m) {
    const auto height = [=](double x, double) { return x > 0.9 ? too_high_m : 0.0; };
    const test::PerceivedTerrain<decltype(height)> map(height, 0.0, 1);
    WalkingRobot robot(test::FlatScene());
    robot.terrain.SetSource(GroundSource::kPerceived, &map);
    EXPECT_TRUE(robot.WalkTo(1.2, 0.4));
    return robot.monitor.counts().worst_foot_drop_m;
  };
  EXPECT_LT(drop_of(0.0), 0.025);
  EXPECT_NEAR(drop_of(0.06), 0.06, 0.025);
}

}  // namespace
}  // namespace atlas::sim
