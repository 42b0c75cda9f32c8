#include <gtest/gtest.h>

#include "core/errors.h"
#include "locomotion_scenes.h"
#include "sim/locomotion/roll_profile.h"
#include "walking_robot.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;
using test::WalkingRobot;

double RollOf(const core::Mat3& R) {
  return std::atan2(R(2, 1), R(2, 2));
}

TEST(Trot, WalksTwentyMetresWithinFivePercentOfItsCommand) {
  for (const double speed : {0.5, 0.8}) {
    WalkingRobot robot(test::FlatScene());
    ASSERT_TRUE(robot.Run(2.0, {speed, 0.0, 0.0}));
    const double from = robot.world.state().p_base.x(), duration = 20.0 / speed;
    ASSERT_TRUE(robot.Run(duration, {speed, 0.0, 0.0}));
    EXPECT_NEAR((robot.world.state().p_base.x() - from) / duration, speed, 0.05 * speed);
    ASSERT_TRUE(robot.Run(3.0, {}));
    EXPECT_TRUE(robot.controller.standing());
    EXPECT_EQ(robot.monitor.counts().collisions, 0);
    EXPECT_EQ(robot.monitor.counts().footholds_off_solid, 0);
  }
}

TEST(Trot, TurnsBothWaysAtItsCommandedRate) {
  for (const double rate : {0.8, -0.8}) {
    WalkingRobot robot(test::FlatScene());
    ASSERT_TRUE(robot.Run(1.0, {0.0, 0.0, rate}));
    double turned = 0.0, last = core::YawOf(robot.world.state().R_base);
    ASSERT_TRUE(robot.Run(5.0, {0.0, 0.0, rate}, [&](const RobotState& state) {
      turned += core::WrapAngle(core::YawOf(state.R_base) - last);
      last = core::YawOf(state.R_base);
    }));
    EXPECT_NEAR(turned / 5.0, rate, 0.05 * std::abs(rate));
    EXPECT_LT(robot.world.state().p_base.head<2>().norm(), 0.15);
  }
}

TEST(Trot, SurvivesAShoveStandingAndWalking) {
  for (const double speed : {0.0, 0.5}) {
    for (const Vec3& force : {Vec3(100.0, 0.0, 0.0), Vec3(0.0, 100.0, 0.0), Vec3(0.0, -100.0, 0.0)}) {
      WalkingRobot robot(test::FlatScene());
      ASSERT_TRUE(robot.Run(1.5, {speed, 0.0, 0.0}));
      robot.world.PushBase(force);
      robot.Run(0.2, {speed, 0.0, 0.0});
      robot.world.PushBase(Vec3::Zero());
      EXPECT_TRUE(robot.Run(3.0, {speed, 0.0, 0.0}));
      EXPECT_LT(std::abs(RollOf(robot.world.state().R_base)), 0.1);
    }
  }
}

TEST(Trot, ARobotThrownOverHasFallen) {
  WalkingRobot robot(test::FlatScene());
  robot.Run(0.5, {});
  robot.world.PushBase(Vec3(0.0, 1500.0, 300.0));
  robot.Run(0.3, {});
  robot.world.PushBase(Vec3::Zero());
  EXPECT_FALSE(robot.Run(3.0, {}));
  EXPECT_EQ(robot.monitor.counts().falls, 1);
}

TEST(Trot, AStateGoneBadIsAFallAndTimeGoesOn) {
  WalkingRobot robot(test::FlatScene());
  robot.Run(0.5, {});
  robot.world.PushBase(Vec3(0.0, 0.0, 1e14));
  EXPECT_FALSE(robot.Run(1.0, {}));
  EXPECT_GT(robot.world.time_s(), 0.499);
  EXPECT_EQ(robot.monitor.counts().falls, 1);
}

TEST(Trot, WalkingIntoAWallIsOneCollisionAnEpisode) {
  scenes::SceneSpec scene = test::FlatScene();
  scene.parts.push_back(test::BoxPart("wall", {0.1, 2.0, 1.0}, test::At(1.6, 0.0, 1.0)));
  WalkingRobot robot(scene);
  ASSERT_TRUE(robot.Run(2.0, {0.4, 0.0, 0.0}));
  EXPECT_EQ(robot.monitor.counts().collisions, 0);
  ASSERT_TRUE(robot.Run(3.0, {0.4, 0.0, 0.0}));
  EXPECT_GE(robot.monitor.counts().collisions, 1);
  EXPECT_LE(robot.monitor.counts().collisions, 3);
}

template <typename HeightAt>
void WalkOnMap(const scenes::SceneSpec& scene, HeightAt height_at, double speed, double x_end) {
  const test::PerceivedTerrain<HeightAt> map(height_at, 0.01, 21);
  WalkingRobot robot(scene);
  robot.terrain.SetSource(GroundSource::kPerceived, &map);
  ASSERT_TRUE(robot.Run(0.5, {}));
  EXPECT_TRUE(robot.WalkTo(x_end, speed));
  EXPECT_EQ(robot.monitor.counts().falls, 0);
  EXPECT_EQ(robot.monitor.counts().collisions, 0);
  EXPECT_EQ(robot.monitor.counts().footholds_off_solid, 0);
}

TEST(Trot, ClimbsATenCentimetreKerbOnANoisyMap) {
  const auto height = [](double x, double) { return x > 1.2 && x < 3.2 ? 0.10 : 0.0; };
  WalkOnMap(test::KerbScene(0.10), height, 0.5, 4.2);
  WalkOnMap(test::KerbScene(0.10), height, 0.3, 4.2);
}

TEST(Trot, CrossesATenDegreeRampOnANoisyMap) {
  const double slope = core::Radians(10.0), run = 3.0 * std::cos(slope), rise = 3.0 * std::sin(slope);
  const auto height = [=](double x, double) {
    const double up = (x - 1.2) * std::tan(slope), down = (3.2 + 2.0 * run - x) * std::tan(slope);
    return std::clamp(std::min(up, down), 0.0, rise);
  };
  WalkOnMap(test::RampScene(slope), height, 0.5, 9.5);
}

TEST(Trot, BodySweepReachesFortyDegreesWithoutAFootSlipping) {
  for (const double slope : {0.0, core::Radians(6.0)}) {
    WalkingRobot robot(test::RampScene(slope > 0.0 ? slope : core::Radians(8.0)));
    ASSERT_TRUE(slope > 0.0 ? robot.WalkTo(2.7, 0.4) : robot.Run(0.5, {}));
    ASSERT_TRUE(robot.Run(2.5, {}));
    ASSERT_TRUE(robot.controller.standing());
    std::array<Vec3, kLegs> at_start;
    for (size_t i = 0; i < kLegs; ++i) at_start[i] = robot.world.state().leg[i].p_foot;

    const RollProfile profile(core::Radians(40.0), 6.0);
    const double start = robot.world.time_s();
    double low = 0.0, high = 0.0, slip = 0.0, error = 0.0;
    ASSERT_TRUE(robot.Run(6.0, {}, [&](const RobotState& state) {
      const BodyRoll roll = profile.At(state.time_s - start);
      robot.controller.SetRoll(roll);
      low = std::min(low, RollOf(state.R_base));
      high = std::max(high, RollOf(state.R_base));
      error = std::max(error, std::abs(RollOf(state.R_base) - roll.roll_rad));
      for (size_t i = 0; i < kLegs; ++i) {
        slip = std::max(slip, (state.leg[i].p_foot - at_start[i]).norm());
      }
    }));
    EXPECT_NEAR(core::Degrees(high), 40.0, 2.5) << "slope " << slope;
    EXPECT_NEAR(core::Degrees(low), -40.0, 2.5) << "slope " << slope;
    EXPECT_LT(core::Degrees(error), 5.0);
    EXPECT_LT(slip, 0.02);
    EXPECT_LT(core::Degrees(std::abs(RollOf(robot.world.state().R_base))), 2.0);
  }
}

TEST(Trot, FootholdBesideAHoleIsMovedToSolidGround) {
  // A trench 12 cm wide across the way: wide enough for a foot, narrow enough to step over.
  scenes::SceneSpec scene;
  scene.name = "trench";
  scene.parts.push_back(test::BoxPart("near", {5.0, 3.0, 0.25}, test::At(-3.5, 0.0, -0.25)));
  scene.parts.push_back(test::BoxPart("far", {5.0, 3.0, 0.25}, test::At(6.62, 0.0, -0.25)));
  WalkingRobot robot(scene);
  ASSERT_TRUE(robot.Run(0.5, {}));
  EXPECT_TRUE(robot.WalkTo(3.0, 0.4));
  EXPECT_EQ(robot.monitor.counts().footholds_off_solid, 0);
}

}  // namespace
}  // namespace atlas::sim
