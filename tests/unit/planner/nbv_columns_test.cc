// What a decision keeps of each candidate, recomputed: gains by what rays end on, extra gains, costs by their
// switches.
#include <gtest/gtest.h>

#include <cmath>

#include "mapping/grid/dense_grid.h"
#include "planner/gain/view_evaluator.h"
#include "tests/support/flat_ground.h"
#include "tests/support/planner_stand.h"

namespace atlas::planner {
namespace {

using core::Box3;
using core::Pose;
using core::Vec2;
using core::Vec3;
using tests::PlannerSettings;
using tests::PlannerStand;
using tests::PlanResult;

const Box3 kHalfKnownBox{Vec3(-1.0, -0.5, 0.0), Vec3(1.0, 0.5, 1.2)};
const ViewTarget kHalfKnownTarget{kHalfKnownBox, kHalfKnownBox.Inflated(0.5)};
const Vec2 kStart(0.0, -3.0);

RobotModel Robot() {
  RobotModel robot;
  robot.sensor.lidar = core::FindLidarModel("vlp16");
  robot.sensor.T_base_lidar.translation().z() = 0.25;
  return robot;
}

/// Half of the object is occupied and half unknown; so is half of the ground that the map holds.
mapping::DenseGrid HalfKnownMap() {
  mapping::DenseGrid map(kHalfKnownBox.Inflated(0.5), 0.1);
  for (size_t i = 0; i < map.frame().count(); ++i) {
    const Vec3 p = map.frame().CenterOf(i);
    const bool thing = std::abs(p.x()) < 1.0 && std::abs(p.y()) < 0.5 && p.z() < 1.2;
    if ((thing || p.z() < 0.0) && p.x() > 0.0) continue;
    const double occupancy = thing || p.z() < 0.0 ? 0.97 : 0.12;
    map.SetLogOdds(i, static_cast<float>(std::log(occupancy / (1.0 - occupancy))));
  }
  map.FinishUpdate();
  return map;
}

PlanResult Decide(const PlannerSettings& params) {
  tests::FlatGround ground(12.0, kStart);
  ground.AddObstacle(kHalfKnownBox.min.head<2>(), kHalfKnownBox.max.head<2>());
  PlannerStand planner(params, {.robot = Robot(),
                                .goal = ObjectInBox{kHalfKnownTarget.object_box},
                                .kept_map = kHalfKnownTarget.seen_box,
                                .terrain = {},
                                .threads = 1,
                                .rng = core::Rng(1)});
  const Pose T_map_base = core::PoseFromXyzYaw(Vec3(kStart.x(), kStart.y(), 0.44), 0.0);
  planner.OnSweep(T_map_base, 500);
  return planner.Plan(T_map_base, HalfKnownMap(), ground);
}

PlannerSettings SmallParams() {
  PlannerSettings params;
  params.Set("nodes", 30);
  params.Set("rays", 300);
  return params;
}

/// The candidate's view evaluated by itself.
ViewGain Evaluated(const Candidate& c, const std::vector<std::string>& gains) {
  const ViewEvaluator evaluator(Robot().sensor, kHalfKnownTarget, {gains, 300, 20.0});
  const ViewNode node{Vec3(c.p_map.x(), c.p_map.y(), c.ground_m), {c.yaw_rad}};
  return evaluator.Evaluate(HalfKnownMap(), {node}, 1).at(0).at(0);
}

TEST(NbvColumns, GainIsSplitByWhatRaysEndOn) {
  const PlannerSettings params = SmallParams();
  const PlanResult decision = Decide(params);
  double in_void = 0.0, on_ground = 0.0, on_object = 0.0;
  for (size_t i = 0; i < decision.candidates.size(); i += 17) {
    const Candidate& c = decision.candidates[i];
    const ViewGain view = Evaluated(c, {"occlusion_aware_normalised"});
    EXPECT_NEAR(*c.gain, view.gain[0], 1e-6 * (1.0 + *c.gain));
    EXPECT_NEAR(c.gain_void, view.by_end[static_cast<size_t>(EndClass::kVoid)], 1e-6 * (1.0 + *c.gain));
    EXPECT_NEAR(c.gain_ground, view.by_end[static_cast<size_t>(EndClass::kGround)], 1e-6 * (1.0 + *c.gain));
    EXPECT_NEAR(c.gain_object, view.by_end[static_cast<size_t>(EndClass::kObject)], 1e-6 * (1.0 + *c.gain));
    in_void += c.gain_void;
    on_ground += c.gain_ground;
    on_object += c.gain_object;
  }
  EXPECT_GT(in_void, 0.0);
  EXPECT_GT(on_object, 0.0);
  EXPECT_NE(on_ground, on_object);
}

TEST(NbvColumns, ExtraGainsAreThoseAskedForInTheirOrder) {
  PlannerSettings params = SmallParams();
  const std::vector<std::string> extra = {"unknown_volume", "rear_side_voxel"};
  params.Set("extra_gains", "[unknown_volume, rear_side_voxel]");
  for (const double gain_share : {0.3, 1.0}) {
    params.Set("gain_share", gain_share);
    const PlanResult decision = Decide(params);
    double volume = 0.0, rear = 0.0;
    for (size_t i = 0; i < decision.candidates.size(); i += 23) {
      const Candidate& c = decision.candidates[i];
      ASSERT_EQ(c.extra_gains.size(), 2u);
      const ViewGain view = Evaluated(c, extra);
      EXPECT_NEAR(c.extra_gains[0], view.gain[0], 1e-6 * (1.0 + view.gain[0]));
      EXPECT_NEAR(c.extra_gains[1], view.gain[1], 1e-6 * (1.0 + view.gain[1]));
      volume += c.extra_gains[0];
      rear += c.extra_gains[1];
    }
    EXPECT_GT(volume, 0.0);
    EXPECT_NE(volume, rear);
  }
}

TEST(NbvColumns, EachCostIsChargedWhereItsSwitchIsOn) {
  const std::vector<core::Vec3f> occupied =
      mapping::OccupiedCenters(HalfKnownMap(), kHalfKnownTarget.seen_box);
  PlannerSettings params = SmallParams();
  params.Set("visited_threshold_m", 3.0);
  params.Set("too_close_threshold_m", 1.7);
  for (const bool visited : {true, false}) {
    for (const bool too_close : {true, false}) {
      params.Set("visited_cost", visited);
      params.Set("too_close_cost", too_close);
      double charged_visited = 0.0, charged_close = 0.0;
      for (const Candidate& c : Decide(params).candidates) {
        const double from_scan = (c.p_map - kStart).norm();
        const double near_scan = std::max(0.0, 1.0 - from_scan / 3.0);
        EXPECT_NEAR(c.visited_cost, visited ? near_scan : 0.0, 1e-9);
        const Vec3 sensor(c.p_map.x(), c.p_map.y(), 0.44 + 0.25);
        double from_object = 1e9;
        for (const core::Vec3f& q : occupied) {
          if (q.z() > 0.15f) from_object = std::min(from_object, (q.cast<double>() - sensor).norm());
        }
        const double near_object = std::max(0.0, 1.0 - from_object / 1.7);
        EXPECT_NEAR(c.too_close_cost, too_close ? near_object : 0.0, 1e-5);
        charged_visited += near_scan;
        charged_close += near_object;
      }
      EXPECT_GT(charged_visited, 0.0);
      EXPECT_GT(charged_close, 0.0);
    }
  }
}

}  // namespace
}  // namespace atlas::planner
