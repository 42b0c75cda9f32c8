// A LiDAR carried along a route: where it goes, how fast it turns, how far it sways.
#include <gtest/gtest.h>

#include "core/rng.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "scenes/route.h"
#include "sim/locomotion/locomotion.h"

namespace atlas::sim {
namespace {

std::unique_ptr<Locomotion> CarriedThrough(const scenes::SceneSpec& scene, const robots::RobotSpec& robot,
                                           const std::string& route, uint64_t seed) {
  SimParams params;
  params.locomotion.name = "carried";
  params.locomotion.route = route;
  return MakeLocomotion(scene, robot, params, core::Rng(seed));
}

class CarriedInTheQuad : public ::testing::Test {
 protected:
  scenes::SceneSpec scene_ = scenes::LoadScene("campus");
  robots::RobotSpec robot_ = robots::LoadRobot("quadruped");

  core::Pose LidarOf(const Locomotion& carried) const { return carried.T_map_base() * robot_.T_base_lidar; }
};

TEST_F(CarriedInTheQuad, GoesAlongItsRouteToWhereThatPassesAndStands) {
  const auto carried = CarriedThrough(scene_, robot_, "campus_long", 1);
  const core::Vec2 goal(0.0, -30.4);
  EXPECT_FALSE(carried->CarryTo({500.0, 0.0}));
  ASSERT_TRUE(carried->CarryTo(goal));
  double fastest = 0.0;
  core::Vec2 last = LidarOf(*carried).translation().head<2>();
  for (int k = 0; k < 60000 && !(carried->standing() && k > 0); ++k) {
    carried->BeginStep();
    carried->FinishStep();
    const core::Vec2 p = LidarOf(*carried).translation().head<2>();
    fastest = std::max(fastest, (p - last).norm() / carried->step_s());
    last = p;
  }
  EXPECT_TRUE(carried->standing());
  EXPECT_LT((last - goal).norm(), 0.6);
  EXPECT_NEAR(fastest, 1.2, 0.1);
  EXPECT_NEAR(LidarOf(*carried).translation().z(), 1.4, 0.15);
}

TEST_F(CarriedInTheQuad, SwaysByThreeDegreesAtTwoHertzAndTurnsNoFasterThanItMay) {
  const auto carried = CarriedThrough(scene_, robot_, "campus_long", 1);
  ASSERT_TRUE(carried->CarryTo({10.0, -20.0}));
  double most_roll = 0.0, fastest_turn = 0.0;
  int crossings = 0;
  double last_roll = 0.0, last_yaw = core::YawOf(LidarOf(*carried).linear());
  const int steps = 20000;  // 100 s
  for (int k = 0; k < steps; ++k) {
    carried->BeginStep();
    carried->FinishStep();
    const core::Mat3 R = LidarOf(*carried).linear();
    const double roll = std::atan2(R(2, 1), R(2, 2)), yaw = core::YawOf(R);
    most_roll = std::max(most_roll, std::abs(roll));
    crossings += k > 0 && roll * last_roll < 0.0;
    fastest_turn = std::max(fastest_turn, std::abs(core::WrapAngle(yaw - last_yaw)) / carried->step_s());
    last_roll = roll;
    last_yaw = yaw;
  }
  EXPECT_LE(core::Degrees(most_roll), 3.0 + 1e-9);
  EXPECT_GT(core::Degrees(most_roll), 2.0);
  EXPECT_NEAR(crossings / 2.0 / (steps * carried->step_s()), 2.0, 0.2);
  EXPECT_LE(core::Degrees(fastest_turn), 90.0 + 25.0);  // and the wobble of +-3 degrees
  EXPECT_GT(core::Degrees(fastest_turn), 60.0);
}

TEST_F(CarriedInTheQuad, TheSeedDecidesTheSway) {
  const auto a = CarriedThrough(scene_, robot_, "campus_long", 1),
             b = CarriedThrough(scene_, robot_, "campus_long", 1),
             c = CarriedThrough(scene_, robot_, "campus_long", 2);
  for (const auto& carried : {a.get(), b.get(), c.get()}) {
    ASSERT_TRUE(carried->CarryTo({0.0, -30.4}));
    for (int k = 0; k < 400; ++k) {
      carried->BeginStep();
      carried->FinishStep();
    }
  }
  EXPECT_EQ(a->T_map_base().matrix(), b->T_map_base().matrix());
  EXPECT_GT((a->T_map_base().matrix() - c->T_map_base().matrix()).norm(), 1e-4);
}

}  // namespace
}  // namespace atlas::sim
