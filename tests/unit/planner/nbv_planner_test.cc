#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "mapping/grid/dense_grid.h"
#include "planner/travel/costs.h"
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

const Box3 kSideMappedBox{Vec3(-1.0, -0.5, 0.0), Vec3(1.0, 0.5, 1.2)};

RobotModel Robot() {
  RobotModel robot;
  robot.sensor.lidar = core::FindLidarModel("vlp16");
  robot.sensor.T_base_lidar.translation().z() = 0.25;
  return robot;
}

PlannerSettings SmallParams(const std::string& name) {
  PlannerSettings params{.name = name, .values = {}};
  params.Set("nodes", 40);
  params.Set("rays", 300);
  params.Set("rrt_star_iterations", 200);
  return params;
}

/// The object's -y face is mapped, all about it but its shadow (y > -0.5) is free.
mapping::DenseGrid NearSideMapped(double p_shadow = 0.5) {
  mapping::DenseGrid map(kSideMappedBox.Inflated(0.5), 0.1);
  for (size_t i = 0; i < map.frame().count(); ++i) {
    const Vec3 p = map.frame().CenterOf(i);
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

tests::FlatGround GroundAboutObject(const Vec2& robot) {
  tests::FlatGround ground(12.0, robot);
  ground.AddObstacle(kSideMappedBox.min.head<2>(), kSideMappedBox.max.head<2>());
  return ground;
}

std::unique_ptr<PlannerStand> Make(const PlannerSettings& params, int threads = 1, uint64_t seed = 1) {
  return std::make_unique<PlannerStand>(params, PlannerSetup{.robot = Robot(),
                                                             .goal = ObjectInBox{kSideMappedBox},
                                                             .kept_map = kSideMappedBox.Inflated(0.5),
                                                             .terrain = {},
                                                             .threads = threads,
                                                             .rng = core::Rng(seed)});
}

const Pose kRobot = core::PoseFromXyzYaw(Vec3(0.0, -3.0, 0.44), 0.0);

/// A greedy planner that has swept where the robot stands, and its first plan.
struct Begun {
  explicit Begun(const mapping::DenseGrid& map) {
    planner->OnSweep(kRobot, 500);
    first = planner->Plan(kRobot, map, GroundAboutObject(Vec2(0.0, -3.0)));
  }
  std::unique_ptr<PlannerStand> planner = Make(SmallParams("greedy"));
  PlanResult first;
};

class EachPlanner : public ::testing::TestWithParam<std::string> {};

TEST_P(EachPlanner, ChoosesTheBestUtilityAndKeepsWhatDecided) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto planner = Make(SmallParams(GetParam()));
  planner->OnSweep(kRobot, 500);
  const PlanResult decision = planner->Plan(kRobot, map, ground);
  ASSERT_EQ(decision.outcome, "view");
  EXPECT_EQ(decision.candidates.size(), 40u * 8u);
  EXPECT_GT(decision.rays_traced, 40u * 300u);
  int chosen = 0;
  const Candidate& best = decision.candidates[static_cast<size_t>(decision.best)];
  for (const Candidate& c : decision.candidates) {
    chosen += c.reason == LossReason::kChosen;
    EXPECT_LE(c.utility, best.utility + 1e-12);
    EXPECT_EQ(c.position_cost, std::max(c.visited_cost, c.too_close_cost));
    EXPECT_NEAR(c.utility, c.worth * (1 - c.position_cost) * (1 - c.traversal_cost), 1e-9 * (1 + c.gain));
    EXPECT_NEAR(c.gain_void + c.gain_ground + c.gain_object, c.gain, 0.2 * c.gain + 1e-9);
  }
  EXPECT_EQ(chosen, 1);
  EXPECT_EQ(decision.path_map.front(), Vec2(0.0, -3.0));
  EXPECT_EQ(decision.path_map.back(), best.p_map);
}

TEST_P(EachPlanner, SameSeedGivesTheSameDecisionWithAnyNumberOfThreads) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto decide = [&](int threads) {
    const auto planner = Make(SmallParams(GetParam()), threads);
    planner->OnSweep(kRobot, 500);
    return planner->Plan(kRobot, map, ground);
  };
  const PlanResult one = decide(1);
  for (const int threads : {1, 2, 3}) {
    const PlanResult other = decide(threads);
    ASSERT_EQ(one.candidates.size(), other.candidates.size());
    for (size_t i = 0; i < one.candidates.size(); ++i) {
      EXPECT_EQ(one.candidates[i].utility, other.candidates[i].utility);
      EXPECT_EQ(one.candidates[i].p_map, other.candidates[i].p_map);
    }
    EXPECT_EQ(one.best, other.best);
    EXPECT_EQ(one.path_map, other.path_map);
  }
}

TEST_P(EachPlanner, NoGroundToStandOnIsATurnThenNoCandidatesAndNeverComplete) {
  tests::FlatGround ground(12.0, Vec2(0.0, -3.0));
  ground.AddObstacle(Vec2(-20.0, -20.0), Vec2(20.0, 20.0));
  const auto map = NearSideMapped();
  const auto planner = Make(SmallParams(GetParam()));
  planner->OnSweep(kRobot, 500);
  const PlanResult turn = planner->Plan(kRobot, map, ground);
  ASSERT_EQ(turn.outcome, "view");
  EXPECT_EQ(turn.path_map, std::vector<Vec2>{Vec2(0.0, -3.0)});
  EXPECT_NEAR(turn.candidates[0].yaw_rad, 0.5 * core::kPi, 1e-12);
  for (int i = 0; i < 8; ++i) {
    planner->OnSweep(kRobot, 0);
    EXPECT_EQ(planner->Plan(kRobot, map, ground).outcome, "no_candidates");
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EachPlanner, ::testing::Values("thesis", "greedy"));

TEST(NbvPlanner, SweepsThatBringNothingEndAGreedyMission) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const PlannerSettings params = SmallParams("greedy");
  const auto planner = Make(params);
  planner->OnSweep(kRobot, 500);
  EXPECT_EQ(planner->Plan(kRobot, map, ground).outcome, "view");
  std::string outcome = "view";
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(outcome, "view");
    planner->OnSweep(kRobot, 0);
    outcome = planner->Plan(kRobot, map, ground).outcome;
  }
  EXPECT_EQ(outcome, "surface_flat") << "views still promise";
}

TEST_P(EachPlanner, AnObjectBeyondPredictionIsWalkedTowardsAndNeverCompleteUnseen) {
  PlannerSettings params = SmallParams(GetParam());
  params.Set("max_range_m", 4.0);
  const auto planner = Make(params);
  const mapping::DenseGrid unknown(kSideMappedBox.Inflated(0.5), 0.1);
  Vec2 robot(0.0, -15.0);
  for (int step = 0; step < 2; ++step) {
    const Pose T = core::PoseFromXyzYaw(Vec3(robot.x(), robot.y(), 0.44), 0.0);
    planner->OnSweep(T, 0);
    const PlanResult decision = planner->Plan(T, unknown, tests::FlatGround(12.0, robot));
    ASSERT_EQ(decision.outcome, "view");
    const Vec2 view = decision.candidates[static_cast<size_t>(decision.best)].p_map;
    EXPECT_GT(view.y(), robot.y() + 2.0);
    robot = view;
  }
  // A trench across the way, farther away than views are predicted.
  const auto other = Make(params);
  tests::FlatGround trench(12.0, Vec2(0.0, -15.0));
  trench.AddObstacle(Vec2(-20.0, -15.5), Vec2(20.0, -14.5));
  trench.AddObstacle(Vec2(-20.0, -14.5), Vec2(20.0, -9.0));
  const Pose T = core::PoseFromXyzYaw(Vec3(0.0, -16.2, 0.44), 0.0);
  std::string outcome = "view";
  for (int plan = 0; plan < 4 && outcome == "view"; ++plan) {
    other->OnSweep(T, 0);
    outcome = other->Plan(T, unknown, trench).outcome;
  }
  EXPECT_EQ(outcome, "out_of_reach");
}

/// Eq. 3.8 and nothing else: the same view again and again while its utility reaches u_thres.
TEST(ThesisPlanner, TakesTheGreatestUtilityUntilItFallsBelowTheThreshold) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  PlannerSettings params = SmallParams("thesis");
  params.Set("visited_cost", false);
  params.Set("stop_utility", 1.0);
  const auto planner = Make(params);
  double best_utility = 0.0;
  for (int i = 0; i < 8; ++i) {
    planner->OnSweep(kRobot, i == 0 ? 500 : 0);
    const PlanResult decision = planner->Plan(kRobot, map, ground);
    ASSERT_EQ(decision.outcome, "view") << "neither flat sweeps nor broken promises end or bend it";
    best_utility = decision.candidates[static_cast<size_t>(decision.best)].utility;
    for (const Candidate& c : decision.candidates) {
      EXPECT_LE(c.utility, best_utility);
      EXPECT_NE(c.reason, LossReason::kBlacklisted);
    }
    // A sweep where it was sent brings nothing.
    const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(view.p_map.x(), view.p_map.y(), 0.44), view.yaw_rad), 0);
  }
  params.Set("stop_utility", 2.0 * best_utility);
  const auto content = Make(params);
  content->OnSweep(kRobot, 500);
  EXPECT_EQ(content->Plan(kRobot, map, ground).outcome, "gain_exhausted") << "with its first plan";
}

TEST(NbvPlanner, GreedyGoesRoundToTheUnseenSide) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto planner = Make(SmallParams("greedy"));
  planner->OnSweep(kRobot, 500);
  const PlanResult decision = planner->Plan(kRobot, map, ground);
  EXPECT_GT(decision.candidates[static_cast<size_t>(decision.best)].p_map.y(), -0.4);
}

TEST(NbvPlanner, GreedyIsExhaustedWhenNothingIsUnknown) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto planner = Make(SmallParams("greedy"));
  planner->OnSweep(kRobot, 500);
  EXPECT_EQ(planner->Plan(kRobot, map, ground).outcome, "gain_exhausted");
}

/// The unseen side lies behind a wall whose only gap is narrower than the robot.
PlanResult EndBehindANarrowGap(const mapping::DenseGrid& map, const PlannerSettings& params) {
  tests::FlatGround ground = GroundAboutObject(Vec2(0.0, -3.0));
  ground.AddObstacle(Vec2(-20.0, 0.0), Vec2(-1.8, 0.2));
  ground.AddObstacle(Vec2(-1.4, 0.0), Vec2(-1.0, 0.2));
  ground.AddObstacle(Vec2(1.0, 0.0), Vec2(20.0, 0.2));
  const auto planner = Make(params);
  planner->OnSweep(kRobot, 500);
  PlanResult decision = planner->Plan(kRobot, map, ground);
  for (int round = 0; round < 20 && decision.outcome == "view"; ++round) {
    planner->OnSweep(kRobot, 0);
    decision = planner->Plan(kRobot, map, ground);
  }
  return decision;
}

TEST(NbvPlanner, AMissionIsNotCompleteWhileMoreIsPromisedBehindAGapTooNarrow) {
  for (const std::string gain : {"surface_frontier", "occlusion_aware", "unobserved_voxel"}) {
    PlannerSettings params = SmallParams("greedy");
    params.Set("gain", gain);
    const PlanResult unseen = EndBehindANarrowGap(NearSideMapped(), params);
    EXPECT_EQ(unseen.outcome, "blocked_narrow") << gain;
    ASSERT_EQ(unseen.blocked.size(), 1u) << gain;
    EXPECT_LT((unseen.blocked[0].p_map - Vec2(-1.6, 0.1)).norm(), 0.2);
    // In shares of the best view's surface, whichever gain is asked for besides.
    EXPECT_GE(unseen.blocked[0].worth_share.value(), 0.2) << gain;
    EXPECT_LT(unseen.blocked[0].worth_share.value(), 5.0) << gain;
    const PlanResult known = EndBehindANarrowGap(NearSideMapped(0.12), params);
    EXPECT_EQ(known.outcome, "gain_exhausted") << gain;
    EXPECT_EQ(known.blocked.at(0).worth_share, 0.0) << gain;
  }
}

TEST(NbvPlanner, PlacesFarFromEveryScanAreLookedAtBeforeItIsExhausted) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  PlannerSettings params = SmallParams("explore");
  params.Set("too_close_cost", true);
  params.Set("stop_ratio", 0.025);
  params.Set("unvisited_m2", 2.0);
  params.Set("unvisited_beyond_m", 5.0);
  const auto planner = Make(params);
  planner->OnSweep(kRobot, 500);
  const PlanResult far = planner->Plan(kRobot, map, ground);
  ASSERT_EQ(far.outcome, "view");
  for (const Candidate& c : far.candidates) {
    const double beyond = std::max(0.0, 1.0 - 5.0 / (c.p_map - Vec2(0.0, -3.0)).norm());
    EXPECT_NEAR(c.worth, 2.0 * beyond, 1e-12) << "nothing is unknown";
  }
  for (const Vec2& p : {Vec2(-4, -7), Vec2(4, -7), Vec2(-4, 1), Vec2(4, 1), Vec2(0, 2)}) {
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(p.x(), p.y(), 0.44), 0.0), 100);
  }
  for (const Candidate& c : planner->Plan(kRobot, map, ground).candidates) EXPECT_EQ(c.worth, 0.0);
}

TEST(NbvPlanner, WhereNothingIsPromisedAnyMoreSomeRoundsGoWhereNoScanWasYet) {
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const PlannerSettings params = SmallParams("greedy");
  const auto planner = Make(params);
  planner->OnSweep(kRobot, 500);
  ASSERT_EQ(planner->Plan(kRobot, NearSideMapped(), ground).outcome, "view");
  const auto known = NearSideMapped(0.12);
  std::vector<Vec2> scans = {Vec2(0.0, -3.0)};
  for (int round = 1; round < 4; ++round) {
    const PlanResult decision = planner->Plan(kRobot, known, ground);
    ASSERT_EQ(decision.outcome, "view") << round;
    const auto nearest = [&](const Candidate& c) { return DistanceToVisited(c.p_map, scans); };
    const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
    for (const Candidate& c : decision.candidates) EXPECT_LE(nearest(c), nearest(view) + 1e-9);
    scans.push_back(view.p_map);
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(view.p_map.x(), view.p_map.y(), 0.44), 0.0), 500);
  }
  EXPECT_EQ(planner->Plan(kRobot, known, ground).outcome, "gain_exhausted");
}

TEST(NbvPlanner, ACommitmentHoldsWhileTheRobotIsOnItsWay) {
  const auto map = NearSideMapped();
  const auto [planner, first] = Begun(map);
  const Candidate& view = first.candidates[static_cast<size_t>(first.best)];
  const Pose on_the_way = core::PoseFromXyzYaw(Vec3(0.3, -2.8, 0.44), 0.3);
  const PlanResult second = planner->Plan(on_the_way, map, GroundAboutObject(Vec2(0.3, -2.8)));
  ASSERT_EQ(second.outcome, "view");
  const Candidate& kept = second.candidates[static_cast<size_t>(second.best)];
  const double best_utility = [&] {
    double best = 0.0;
    for (const Candidate& c : second.candidates) best = std::max(best, c.utility);
    return best;
  }();
  const bool same_place = (kept.p_map - view.p_map).norm() < 0.5;
  EXPECT_TRUE(same_place || kept.utility == best_utility);
  EXPECT_GE(kept.utility * 1.151, best_utility);
}

/// Of two views that promise alike, the one that the robot set out for; a margin says how much better another
/// must be.
TEST(NbvPlanner, ACommitmentYieldsToAViewThatIsBetterByTheMarginOnly) {
  const auto map = NearSideMapped();
  int kept = 0, turned = 0;
  for (const double margin : {10.0, 0.0}) {
    for (const Vec2& on_the_way :
         {Vec2(0.3, -2.8), Vec2(1.5, -3.0), Vec2(-1.5, -3.0), Vec2(2.5, -2.0), Vec2(-2.5, -2.0)}) {
      PlannerSettings params = SmallParams("greedy");
      params.Set("commit_margin", margin);
      params.Set("nodes", 600);  // every place of the lattice, whichever the robot stands at
      params.Set("rays", 100);
      const auto planner = Make(params);
      planner->OnSweep(kRobot, 500);
      const PlanResult first = planner->Plan(kRobot, map, GroundAboutObject(Vec2(0.0, -3.0)));
      const Pose there = core::PoseFromXyzYaw(Vec3(on_the_way.x(), on_the_way.y(), 0.44), 0.3);
      const PlanResult second = planner->Plan(there, map, GroundAboutObject(on_the_way));
      ASSERT_EQ(second.outcome, "view");
      const Candidate& before = first.candidates[static_cast<size_t>(first.best)];
      const auto same = [&](const Candidate& c) {
        return (c.p_map - before.p_map).norm() < 0.5 &&
               std::abs(core::WrapAngle(c.yaw_rad - before.yaw_rad)) < core::Radians(50.0) && c.utility > 0.0;
      };
      if (std::none_of(second.candidates.begin(), second.candidates.end(), same)) continue;
      const bool keeps = same(second.candidates[static_cast<size_t>(second.best)]);
      EXPECT_TRUE(keeps || margin == 0.0) << on_the_way.transpose();
      kept += margin > 0.0 && keeps;
      turned += margin == 0.0 && !keeps;
    }
  }
  EXPECT_GT(kept, 0);
  EXPECT_GT(turned, 0) << "without a margin the greatest utility is taken";
}

TEST(NbvPlanner, ViewsThatBreakTheirPromisesAreDropped) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  PlannerSettings params = SmallParams("greedy");
  params.Set("distrust_m", 0.0);
  params.Set("visited_cost", false);
  params.Set("flat_rounds", 100);
  const auto planner = Make(params);
  planner->OnSweep(kRobot, 500);
  std::vector<Vec2> chosen;
  for (int i = 0; i < 3; ++i) {
    const PlanResult decision = planner->Plan(kRobot, map, ground);
    ASSERT_EQ(decision.outcome, "view");
    const Candidate& c = decision.candidates[static_cast<size_t>(decision.best)];
    chosen.push_back(c.p_map);
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(c.p_map.x(), c.p_map.y(), 0.44), c.yaw_rad), 0);
  }
  EXPECT_EQ(chosen[0], chosen[1]);
  EXPECT_GT((chosen[2] - chosen[0]).norm(), 0.7);
}

/// The robot went to a view, and learnt there that nothing about it is walkable.
TEST(NbvPlanner, ARobotThatFindsNothingWalkableGoesBackTheWayItCameOnce) {
  const auto map = NearSideMapped();
  const auto [planner, there] = Begun(map);
  ASSERT_EQ(there.outcome, "view");
  const Vec2 view = there.path_map.back() + Vec2(0.04, -0.03);
  const Pose arrived = core::PoseFromXyzYaw(Vec3(view.x(), view.y(), 0.44), 0.7);
  tests::FlatGround nothing(12.0, view);
  nothing.AddObstacle(Vec2(-20.0, -20.0), Vec2(20.0, 20.0));

  planner->OnSweep(arrived, 0);
  const PlanResult back = planner->Plan(arrived, map, nothing);
  ASSERT_EQ(back.outcome, "view");
  std::vector<Vec2> way(there.path_map.rbegin(), there.path_map.rend());
  way.front() = view;
  EXPECT_EQ(back.path_map, way);
  double length = 0.0;
  for (size_t i = 1; i < way.size(); ++i) length += (way[i] - way[i - 1]).norm();
  EXPECT_NEAR(back.path_length_m, length, 1e-12);
  ASSERT_EQ(back.best, 0);
  EXPECT_EQ(back.candidates.front().p_map, Vec2(0.0, -3.0));
  EXPECT_EQ(back.candidates.front().reason, LossReason::kChosen);
  const Vec2 last = way.back() - way[way.size() - 2];
  EXPECT_NEAR(back.candidates.front().yaw_rad, std::atan2(last.y(), last.x()), 1e-12);

  planner->OnSweep(kRobot, 0);
  const PlanResult turn = planner->Plan(kRobot, map, nothing);
  EXPECT_EQ(turn.path_map, std::vector<Vec2>{Vec2(0.0, -3.0)}) << "not back again";
  planner->OnSweep(kRobot, 0);
  EXPECT_EQ(planner->Plan(kRobot, map, nothing).outcome, "no_candidates");
}

TEST(NbvPlanner, ViewsAboutABrokenPromiseAreWorthLess) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  std::vector<std::vector<Candidate>> by_distrust;
  Vec2 broken = Vec2::Zero();
  for (const double distrust_m : {0.0, 4.0}) {
    PlannerSettings params = SmallParams("greedy");
    params.Set("distrust_m", distrust_m);
    const auto planner = Make(params);
    planner->OnSweep(kRobot, 500);
    const PlanResult first = planner->Plan(kRobot, map, ground);
    ASSERT_EQ(first.outcome, "view");
    broken = first.candidates[static_cast<size_t>(first.best)].p_map;
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(broken.x(), broken.y(), 0.44), 0.0), 0);
    by_distrust.push_back(planner->Plan(kRobot, map, ground).candidates);
  }
  ASSERT_EQ(by_distrust[0].size(), by_distrust[1].size());
  int less = 0;
  for (size_t i = 0; i < by_distrust[0].size(); ++i) {
    const Candidate &whole = by_distrust[0][i], &doubted = by_distrust[1][i];
    ASSERT_EQ(whole.p_map, doubted.p_map);
    const double trust = 1.0 - std::exp(-(whole.p_map - broken).squaredNorm() / 16.0);
    EXPECT_NEAR(doubted.worth, whole.worth * trust, 1e-9);
    less += doubted.worth < 0.5 * whole.worth;
  }
  EXPECT_GT(less, 5);
}

TEST(NbvPlanner, ARobotOffItsWayHasNoWayBack) {
  const auto map = NearSideMapped();
  const auto [planner, there] = Begun(map);
  ASSERT_EQ(there.outcome, "view");
  const Vec2 aside = there.path_map.back() + Vec2(0.6, 0.0);
  tests::FlatGround nothing(12.0, aside);
  nothing.AddObstacle(Vec2(-20.0, -20.0), Vec2(20.0, 20.0));
  const Pose stopped = core::PoseFromXyzYaw(Vec3(aside.x(), aside.y(), 0.44), 0.0);
  EXPECT_EQ(planner->Plan(stopped, map, nothing).path_map, std::vector<Vec2>{aside}) << "a turn";
  EXPECT_EQ(planner->Plan(stopped, map, nothing).outcome, "no_candidates");
}

TEST(NbvPlanner, TheWindowIsTheSmallerOfThePlannersAndTheTerrains) {
  const auto map = NearSideMapped();
  PlannerSettings params = SmallParams("greedy");
  for (const double side : {4.0, 30.0}) {
    params.Set("window_m", side);
    const auto planner = Make(params);
    planner->OnSweep(kRobot, 500);
    double farthest = 0.0;
    for (const Candidate& c : planner->Plan(kRobot, map, GroundAboutObject(Vec2(0.0, -3.0))).candidates) {
      farthest = std::max(farthest, (c.p_map - Vec2(0.0, -3.0)).cwiseAbs().maxCoeff());
    }
    EXPECT_NEAR(farthest, 0.5 * std::min(side, 12.0), 0.5);
  }
}

TEST(FrontierPlanner, GoesToTheNearestViewThatUncoversEnough) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  PlannerSettings params{.name = "frontier", .values = {}};
  params.Set("nodes", 60);
  params.Set("rays", 300);
  params.Set("frontier_m2", 0.2);
  const auto planner = Make(params);
  planner->OnSweep(kRobot, 500);
  const PlanResult decision = planner->Plan(kRobot, map, ground);
  ASSERT_EQ(decision.outcome, "view");
  const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
  EXPECT_GE(view.gain, 0.2);
  size_t nearer = 0, farther = 0;
  for (const Candidate& c : decision.candidates) {
    nearer += c.gain >= 0.2 && c.path_length_m < view.path_length_m - 1e-9;
    farther += c.gain >= 0.2 && c.path_length_m > view.path_length_m + 0.5;
  }
  EXPECT_EQ(nearer, 0u);
  EXPECT_GT(farther, 0u);
  const auto done = Make(params);
  done->OnSweep(kRobot, 500);
  EXPECT_EQ(done->Plan(kRobot, NearSideMapped(0.12), ground).outcome, "gain_exhausted");
}

TEST(RandomPlanner, TakesReachableViewsOfAllDirectionsAndNeverEnds) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto decide = [&](uint64_t seed) {
    const auto planner = Make({.name = "random", .values = {}}, 1, seed);
    std::vector<Vec2> views;
    for (int i = 0; i < 40; ++i) {
      planner->OnSweep(kRobot, 0);
      const PlanResult decision = planner->Plan(kRobot, map, ground);
      EXPECT_EQ(decision.outcome, "view");
      views.push_back(decision.path_map.back());
    }
    return views;
  };
  const std::vector<Vec2> views = decide(1);
  EXPECT_EQ(views, decide(1));
  EXPECT_NE(views, decide(2));
  int left = 0, ahead = 0;
  for (const Vec2& p : views) {
    EXPECT_EQ(ground.KindAt({p.x(), p.y(), 0.0}), mapping::GroundKind::kFree);
    left += p.x() < 0.0;
    ahead += p.y() > -3.0;
  }
  EXPECT_NEAR(left, 20, 12);
  EXPECT_NEAR(ahead, 20, 12);
}

TEST(NbvPlanner, UnknownNamesAreRefused) {
  EXPECT_THROW(Make({.name = "greeedy", .values = {}}), core::InputError);
  PlannerSettings params;
  params.Set("gain", "entropy_of_everything");
  EXPECT_THROW(Make(params), core::InputError);
}

}  // namespace
}  // namespace atlas::planner
