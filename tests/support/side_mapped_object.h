// An object whose near side is mapped, a robot before it, and planners that are asked there.
#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "mapping/grid/dense_grid.h"
#include "tests/support/flat_ground.h"
#include "tests/support/planner_stand.h"

namespace atlas::tests {

inline const core::Box3 kSideMappedBox{core::Vec3(-1.0, -0.5, 0.0), core::Vec3(1.0, 0.5, 1.2)};

inline planner::RobotModel SmallRobot() {
  planner::RobotModel robot;
  robot.sensor.lidar = core::FindLidarModel("vlp16");
  robot.sensor.T_base_lidar.translation().z() = 0.25;
  return robot;
}

inline PlannerSettings SmallPlanner(const std::string& name) {
  PlannerSettings params{.name = name, .values = {}};
  params.Set("nodes", 40);
  params.Set("rays", 300);
  params.Set("rrt_star_iterations", 200);
  return params;
}

/// The object's -y face is mapped, all about it but its shadow (y > -0.5) is free.
inline mapping::DenseGrid NearSideMapped(double p_shadow = 0.5) {
  mapping::DenseGrid map(kSideMappedBox.Inflated(0.5), 0.1);
  for (size_t i = 0; i < map.frame().count(); ++i) {
    const core::Vec3 p = map.frame().CenterOf(i);
    double occupancy = 0.12;
    if (std::abs(p.x()) < 1.0 && p.z() < 1.2) {
      if (p.y() > -0.5 && p.y() < -0.4) occupancy = 0.97;
      if (p.y() > -0.4) occupancy = p_shadow;
    }
    if (p.z() < 0.0) occupancy = 0.97;
    if (occupancy != 0.5) map.SetLogOdds(i, static_cast<float>(std::log(occupancy / (1.0 - occupancy))));
  }
  map.FinishUpdate();
  return map;
}

inline FlatGround GroundAboutObject(const core::Vec2& robot) {
  FlatGround ground(12.0, robot);
  ground.AddObstacle(kSideMappedBox.min.head<2>(), kSideMappedBox.max.head<2>());
  return ground;
}

inline std::unique_ptr<PlannerStand> StandAtObject(const PlannerSettings& params, int threads = 1,
                                                   uint64_t seed = 1) {
  return std::make_unique<PlannerStand>(params,
                                        planner::PlannerSetup{.robot = SmallRobot(),
                                                              .goal = planner::ObjectInBox{kSideMappedBox},
                                                              .kept_map = kSideMappedBox.Inflated(0.5),
                                                              .terrain = {},
                                                              .threads = threads,
                                                              .rng = core::Rng(seed)});
}

inline const core::Pose kStandAtObject = core::PoseFromXyzYaw(core::Vec3(0.0, -3.0, 0.44), 0.0);

/// A greedy planner that has swept where the robot stands, and its first plan.
struct Begun {
  explicit Begun(const mapping::DenseGrid& map) {
    planner->OnSweep(kStandAtObject, 500);
    first = planner->Plan(kStandAtObject, map, GroundAboutObject(core::Vec2(0.0, -3.0)));
  }
  std::unique_ptr<PlannerStand> planner = StandAtObject(SmallPlanner("greedy"));
  PlanResult first;
};

}  // namespace atlas::tests
