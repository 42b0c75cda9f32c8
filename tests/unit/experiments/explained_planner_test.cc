// Every parameter of every planner (but for three, named below) does something: changed alone, it changes
// what the planner decides on its way through a small world, which costs a
// hundredth of a mission. A mission builds the planner from its section as it
// is here (ExplainedParameters.EverySectionReachesTheMission).
#include <gtest/gtest.h>

#include "mapping/grid/dense_grid.h"
#include "tests/support/explained_rows.h"
#include "tests/support/flat_ground.h"
#include "tests/support/planner_stand.h"
#include "tests/support/tiny_mission.h"

namespace atlas::experiments {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;
using tests::Digest;
using tests::PlanResult;
using tests::Settings;

const core::Box3 kObject{Vec3(-1.0, -0.5, 0.0), Vec3(1.0, 0.5, 1.2)};
const Vec2 kStart(0.0, -3.0);

/// The object's -y face is mapped; about it all is free but its shadow.
mapping::DenseGrid NearSideMapped() {
  mapping::DenseGrid map(kObject.Inflated(0.5), 0.1);
  for (size_t i = 0; i < map.frame().count(); ++i) {
    const Vec3 p = map.frame().CenterOf(i);
    const bool in_object = std::abs(p.x()) < 1.0 && p.z() < 1.2 && p.y() > -0.5;
    if (p.z() < 0.0 || (in_object && p.y() < -0.4)) {
      map.SetLogOdds(i, 3.4f);
    } else if (!in_object) {
      map.SetLogOdds(i, -2.0f);
    } else if (p.y() < -0.2) {
      map.SetBehindSurface(i, 2);
    }
  }
  map.FinishUpdate();
  return map;
}

/// Walls about the object: to the right a doorway that the robot passes but
/// cannot turn in, to the left a gap too narrow for it.
tests::FlatGround Rooms() {
  tests::FlatGround ground(9.0, kStart);
  ground.AddObstacle(kObject.min.head<2>(), kObject.max.head<2>());
  ground.AddObstacle({2.5, -20}, {2.7, -3.35});
  ground.AddObstacle({2.5, -2.45}, {2.7, 20});
  ground.AddObstacle({-2.7, -20}, {-2.5, -3.0});
  ground.AddObstacle({-2.7, -2.5}, {-2.5, 20});
  ground.AddObstacle({6, -20}, {7, 20});
  ground.AddObstacle({-20, 3}, {20, 4});
  ground.AddObstacle({-20, -6.5}, {20, -5.5});
  return ground;
}

void Tell(const PlanResult& decision, Digest* told) {
  told->Add(decision.outcome);
  told->Add(decision.nodes_obtained);
  told->Add(decision.rays_traced);
  told->Add(decision.utility_ratio.value_or(-1.0));
  told->Add(decision.path_map);
  for (const planner::Candidate& c : decision.candidates) {
    told->Add(c.p_map);
    told->Add(std::vector<double>{c.yaw_rad, c.position_cost, c.traversal_cost});
    for (const auto& number : {c.gain, c.surface_m2, c.worth, c.utility}) told->Add(number.value_or(-1.0));
    told->Add(c.extra_gains);
    told->Add(c.reason);
  }
  if (!decision.blocked) return;
  for (const planner::BlockedWay& way : *decision.blocked) told->Add(way.worth_share.value_or(0.0));
}

/// Sweeps bring ever less. The second way ends early, with the robot turned
/// away from the view.
std::string PlannerDecides(const ExperimentConfig& config) {
  planner::RobotModel robot;
  robot.sensor.lidar = core::FindLidarModel("vlp16");
  robot.sensor.T_base_lidar.translation().z() = 0.25;
  tests::PlannerStand nbv(config.planner, {.robot = robot,
                                           .goal = planner::ObjectInBox{kObject},
                                           .kept_map = kObject.Inflated(0.5),
                                           .terrain = {},
                                           .threads = 1,
                                           .rng = core::Rng(1)});
  const mapping::DenseGrid map = NearSideMapped();
  tests::FlatGround ground = Rooms();
  Pose T_map_base = core::PoseFromXyzYaw(Vec3(kStart.x(), kStart.y(), 0.44), 0.0);
  Digest told;
  const std::vector<size_t> new_surface = {500, 300, 15, 15, 0, 0, 0, 0};
  for (size_t round = 0; round < new_surface.size(); ++round) {
    nbv.OnSweep(T_map_base, new_surface[round]);
    const PlanResult decision = nbv.Plan(T_map_base, map, ground);
    Tell(decision, &told);
    if (decision.outcome != "view") break;
    const planner::Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
    Vec2 there = decision.path_map.back();
    double yaw_rad = view.yaw_rad;
    if (round == 1) {
      const Vec2 way = there - decision.path_map.front();
      there -= 0.7 * way;
      yaw_rad = std::atan2(-way.y(), -way.x());
    }
    T_map_base = core::PoseFromXyzYaw(Vec3(there.x(), there.y(), 0.44), yaw_rad);
    ground.SetRobot(there);
  }
  return told.text();
}

class ExplainedPlanner : public ::testing::Test {
 protected:
  tests::TinyMissions missions_;
  tests::ParameterProbe probe_{
      [this](const std::vector<std::string>& set) { return missions_.LoadBare(set); }, PlannerDecides};
};

const std::vector<std::string> kSmall = {"planner.nodes=5", "planner.rays=100", "planner.headings=2",
                                         "planner.rrt_star_iterations=100"};
const Settings kOfBoth = {
    {"planner.name", {{}, "thesis"}},
    {"planner.window_m", {{}, "5"}},
    {"planner.max_range_m", {{}, "6"}},
    {"planner.time_scale_s", {{"planner.traversal=continuous"}}},
    {"planner.rrt_star_iterations", {{"planner.nodes=15"}, "1000"}},
};

TEST_F(ExplainedPlanner, OfGreedyAct) {
  Settings settings = kOfBoth;
  // Greedy samples only where no place of its lattice can be reached.
  settings["planner.rrt_step_m"] = {{"planner.lattice_m=5", "planner.window_m=3"}, "0.3"};
  settings["planner.roadmap"] = {{"planner.window_m=6"}};
  settings["planner.blacklist_after"] = {{"planner.distrust_m=0"}, "1"};
  settings["planner.blocked_share"] = {{"planner.nodes=20", "planner.flat_rounds=2"}, "1"};
  settings["planner.commit_margin"] = {{"planner.commit_margin=10", "planner.behind_penalty=0.9"}, "0"};
  settings["planner.flat_rounds"] = {{}, "2"};
  settings["planner.rrt_star_iterations"] = {{}, "1000"};
  settings["planner.stop_ratio"] = {{}, "1"};
  settings["planner.stop_rounds"] = {{"planner.stop_ratio=1"}, "2"};
  settings["planner.flat_share"] = {{"planner.stop_ratio=1", "planner.stop_rounds=2"}};
  std::vector<std::string> context = kSmall;
  context.insert(context.begin(), "planner=greedy");
  probe_.SeeNothingElseAct(context);
  EXPECT_GT(probe_.SeeThemAct("planner", context, settings), 28);
}

TEST_F(ExplainedPlanner, OfTheThesisAct) {
  Settings settings = kOfBoth;
  settings["planner.name"] = {{}, "greedy"};
  settings["planner.max_range_m"] = {{}, "2.5"};
  settings["planner.stop_utility"] = {{}, "1e6"};
  settings["planner.blocked_share"] = {{"planner.stop_utility=1e6"}, "0.5"};
  std::vector<std::string> context = kSmall;
  context.insert(context.begin(), "planner=thesis");
  probe_.SeeNothingElseAct(context);
  EXPECT_GT(probe_.SeeThemAct("planner", context, settings), 15);
}

TEST_F(ExplainedPlanner, OfExploreAct) {
  Settings settings = kOfBoth;
  settings["planner.rrt_step_m"] = {{"planner.lattice_m=5", "planner.window_m=3"}, "0.3"};
  settings["planner.rrt_star_iterations"] = {{"planner.lattice_m=1.2"}, "5000"};
  settings["planner.unvisited_m2"] = {{"planner.unvisited_beyond_m=0.5"}};
  settings["planner.unvisited_beyond_m"] = {{"planner.unvisited_m2=5", "planner.unvisited_beyond_m=0.5"},
                                            "1"};
  settings["planner.blacklist_after"] = {{}, "1"};
  settings["planner.blocked_share"] = {
      {"planner.nodes=20", "planner.flat_rounds=2", "planner.flat_share=0.012"}, "1"};
  settings["planner.commit_margin"] = {
      {"planner.commit_margin=10", "planner.behind_penalty=0.9", "planner.too_close_cost=true",
       "planner.visited_threshold_m=2", "planner.unvisited_m2=0"},
      "0"};
  settings["planner.flat_rounds"] = {{"planner.flat_share=0.012"}, "2"};
  settings["planner.too_close_cost"] = {{}, "true"};
  settings["planner.too_close_threshold_m"] = {{"planner.too_close_cost=true"}};
  settings["planner.stop_ratio"] = {{"planner.flat_share=0.012"}, "1"};
  settings["planner.stop_rounds"] = {{"planner.stop_ratio=1", "planner.flat_share=0.012"}, "2"};
  settings["planner.flat_share"] = {{"planner.stop_ratio=1", "planner.stop_rounds=2"}, "0.05"};
  std::vector<std::string> context = kSmall;
  context.insert(context.begin(), "planner=explore");
  EXPECT_GT(probe_.SeeThemAct("planner", context, settings), 25);
}

/// All but RRT*, which acts under the other planners: places at random are rarely behind something here.
TEST_F(ExplainedPlanner, OfTheSimplestAct) {
  probe_.SeeItAct("planner.window_m", {"planner=random"}, {{}, "5"});
  probe_.SeeItAct("planner.lattice_m", {"planner=random"}, {});
  probe_.SeeItAct("planner.name", {"planner=random"}, {{}, "greedy"});
}

/// All but two, which act under the other planners: the nearest view of this world lies straight ahead, so
/// that RRT* has nothing to shorten, and what the gap hides is worth more than any view here, whatever the
/// share.
TEST_F(ExplainedPlanner, OfTheNearestFrontierAct) {
  std::vector<std::string> context = kSmall;
  context.insert(context.begin(), "planner=frontier");
  const std::vector<std::string> wide = {"planner.frontier_m2=0.1", "planner.nodes=20"};
  const Settings settings = {{"planner.window_m", {{}, "5"}},
                             {"planner.max_range_m", {{}, "6"}},
                             {"planner.frontier_m2", {{}, "2"}},
                             {"planner.dropped_after", {wide, "3"}}};
  for (const char* name : {"window_m", "max_range_m", "frontier_m2", "dropped_after", "lattice_m", "nodes",
                           "headings", "rays"}) {
    const std::string path = std::string("planner.") + name;
    const auto found = settings.find(path);
    probe_.SeeItAct(path, context, found == settings.end() ? tests::Setting{} : found->second);
  }
}

TEST_F(ExplainedPlanner, OfTheRouteAct) {
  probe_.SeeItAct("planner.route", {"planner=route", "planner.route=[0 -3, 0 -2.5 0]"},
                  {{}, "[0 -3, 0 -2 0]"});
}

}  // namespace
}  // namespace atlas::experiments
