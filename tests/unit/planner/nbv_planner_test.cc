#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "planner/travel/costs.h"
#include "tests/support/side_mapped_object.h"

namespace atlas::planner {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;
using namespace tests;

class EachPlanner : public ::testing::TestWithParam<std::string> {};

TEST_P(EachPlanner, ChoosesTheBestUtilityAndKeepsWhatDecided) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto planner = StandAtObject(SmallPlanner(GetParam()));
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
  ASSERT_EQ(decision.outcome, "view");
  EXPECT_EQ(decision.candidates.size(), 40u * 8u);
  EXPECT_GT(decision.rays_traced, 40u * 300u);
  int chosen = 0;
  const Candidate& best = decision.candidates[static_cast<size_t>(decision.best)];
  for (const Candidate& c : decision.candidates) {
    chosen += c.reason == LossReason::kChosen;
    EXPECT_LE(*c.utility, *best.utility + 1e-12);
    EXPECT_EQ(c.position_cost, std::max(c.visited_cost, c.too_close_cost));
    EXPECT_NEAR(*c.utility, *c.worth * (1 - c.position_cost) * (1 - c.traversal_cost), 1e-9 * (1 + *c.gain));
    EXPECT_NEAR(c.gain_void + c.gain_ground + c.gain_object, *c.gain, 0.2 * *c.gain + 1e-9);
  }
  EXPECT_EQ(chosen, 1);
  EXPECT_EQ(decision.path_map.front(), Vec2(0.0, -3.0));
  EXPECT_EQ(decision.path_map.back(), best.p_map);
}

TEST_P(EachPlanner, SameSeedGivesTheSameDecisionWithAnyNumberOfThreads) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto decide = [&](int threads) {
    const auto planner = StandAtObject(SmallPlanner(GetParam()), threads);
    planner->OnSweep(kStandAtObject, 500);
    return planner->Plan(kStandAtObject, map, ground);
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
  const auto planner = StandAtObject(SmallPlanner(GetParam()));
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult turn = planner->Plan(kStandAtObject, map, ground);
  ASSERT_EQ(turn.outcome, "view");
  EXPECT_EQ(turn.path_map, std::vector<Vec2>{Vec2(0.0, -3.0)});
  EXPECT_NEAR(turn.candidates[0].yaw_rad, 0.5 * core::kPi, 1e-12);
  EXPECT_NEAR(turn.candidates[0].ground_m, 0.0, 1e-12) << "under a base 0.44 m above it";
  EXPECT_FALSE(turn.candidates[0].gain || turn.candidates[0].utility) << "no view was predicted";
  EXPECT_EQ(turn.views_predicted, 0u);
  for (int i = 0; i < 8; ++i) {
    planner->OnSweep(kStandAtObject, 0);
    EXPECT_EQ(planner->Plan(kStandAtObject, map, ground).outcome, "no_candidates");
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EachPlanner, ::testing::Values("thesis", "greedy"));

TEST(NbvPlanner, SweepsThatBringNothingEndAGreedyMission) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const PlannerSettings params = SmallPlanner("greedy");
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  EXPECT_EQ(planner->Plan(kStandAtObject, map, ground).outcome, "view");
  std::string outcome = "view";
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(outcome, "view");
    planner->OnSweep(kStandAtObject, 0);
    outcome = planner->Plan(kStandAtObject, map, ground).outcome;
  }
  EXPECT_EQ(outcome, "surface_flat") << "views still promise";
}

/// What an object's mission calls gain_exhausted is a space explored; no other ending is.
TEST(NbvPlanner, OnlyASpaceThatPromisesNoMoreIsExplored) {
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto stand = [] {
    PlannerStand planner(SmallPlanner("greedy"), PlannerSetup{.robot = tests::SmallRobot(),
                                                              .goal = WholeSpace{kSideMappedBox},
                                                              .kept_map = kSideMappedBox.Inflated(0.5),
                                                              .terrain = {},
                                                              .threads = 1,
                                                              .rng = core::Rng(1)});
    planner.OnSweep(kStandAtObject, 500);
    return planner;
  };
  PlannerStand seen = stand();
  EXPECT_EQ(seen.Plan(kStandAtObject, NearSideMapped(0.12), ground).outcome, "explored");
  PlannerStand flat = stand();
  const auto unseen = NearSideMapped();
  std::string outcome = flat.Plan(kStandAtObject, unseen, ground).outcome;
  for (int i = 0; i < 6 && outcome == "view"; ++i) {
    flat.OnSweep(kStandAtObject, 0);
    outcome = flat.Plan(kStandAtObject, unseen, ground).outcome;
  }
  EXPECT_EQ(outcome, "surface_flat");
}

TEST_P(EachPlanner, AnObjectBeyondPredictionIsWalkedTowardsAndNeverCompleteUnseen) {
  PlannerSettings params = SmallPlanner(GetParam());
  params.Set("max_range_m", 4.0);
  const auto planner = StandAtObject(params);
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
  const auto other = StandAtObject(params);
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
  PlannerSettings params = SmallPlanner("thesis");
  params.Set("visited_cost", false);
  params.Set("stop_utility", 1.0);
  const auto planner = StandAtObject(params);
  double best_utility = 0.0;
  for (int i = 0; i < 8; ++i) {
    planner->OnSweep(kStandAtObject, i == 0 ? 500 : 0);
    const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
    ASSERT_EQ(decision.outcome, "view") << "neither flat sweeps nor broken promises end or bend it";
    best_utility = decision.candidates[static_cast<size_t>(decision.best)].utility.value();
    for (const Candidate& c : decision.candidates) {
      EXPECT_LE(c.utility, best_utility);
      EXPECT_NE(c.reason, LossReason::kBlacklisted);
    }
    // A sweep where it was sent brings nothing.
    const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(view.p_map.x(), view.p_map.y(), 0.44), view.yaw_rad), 0);
  }
  params.Set("stop_utility", 2.0 * best_utility);
  const auto content = StandAtObject(params);
  content->OnSweep(kStandAtObject, 500);
  EXPECT_EQ(content->Plan(kStandAtObject, map, ground).outcome, "gain_exhausted") << "with its first plan";
}

TEST(NbvPlanner, GreedyGoesRoundToTheUnseenSide) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto planner = StandAtObject(SmallPlanner("greedy"));
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
  EXPECT_GT(decision.candidates[static_cast<size_t>(decision.best)].p_map.y(), -0.4);
}

TEST(NbvPlanner, GreedyIsExhaustedWhenNothingIsUnknown) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const auto planner = StandAtObject(SmallPlanner("greedy"));
  planner->OnSweep(kStandAtObject, 500);
  EXPECT_EQ(planner->Plan(kStandAtObject, map, ground).outcome, "gain_exhausted");
}

/// The unseen side lies behind a wall whose only gap is narrower than the robot.
PlanResult EndBehindANarrowGap(const mapping::DenseGrid& map, const PlannerSettings& params) {
  tests::FlatGround ground = GroundAboutObject(Vec2(0.0, -3.0));
  ground.AddObstacle(Vec2(-20.0, 0.0), Vec2(-1.8, 0.2));
  ground.AddObstacle(Vec2(-1.4, 0.0), Vec2(-1.0, 0.2));
  ground.AddObstacle(Vec2(1.0, 0.0), Vec2(20.0, 0.2));
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  PlanResult decision = planner->Plan(kStandAtObject, map, ground);
  for (int round = 0; round < 20 && decision.outcome == "view"; ++round) {
    planner->OnSweep(kStandAtObject, 0);
    decision = planner->Plan(kStandAtObject, map, ground);
  }
  return decision;
}

TEST(NbvPlanner, AMissionIsNotCompleteWhileMoreIsPromisedBehindAGapTooNarrow) {
  for (const std::string gain : {"surface_frontier", "occlusion_aware", "unobserved_voxel"}) {
    PlannerSettings params = SmallPlanner("greedy");
    params.Set("gain", gain);
    const PlanResult unseen = EndBehindANarrowGap(NearSideMapped(), params);
    EXPECT_EQ(unseen.outcome, "blocked_narrow") << gain;
    ASSERT_EQ(unseen.blocked->size(), 1u) << gain;
    EXPECT_LT((unseen.blocked->at(0).p_map - Vec2(-1.6, 0.1)).norm(), 0.2);
    // In shares of the best view's surface, whichever gain is asked for besides.
    EXPECT_GE(unseen.blocked->at(0).worth_share.value(), 0.2) << gain;
    EXPECT_LT(unseen.blocked->at(0).worth_share.value(), 5.0) << gain;
    const PlanResult known = EndBehindANarrowGap(NearSideMapped(0.12), params);
    EXPECT_EQ(known.outcome, "gain_exhausted") << gain;
    EXPECT_EQ(known.blocked->at(0).worth_share, 0.0) << gain;
  }
}

TEST(NbvPlanner, PlacesFarFromEveryScanAreLookedAtBeforeItIsExhausted) {
  const auto map = NearSideMapped(0.12);
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  PlannerSettings params = SmallPlanner("explore");
  params.Set("too_close_cost", true);
  params.Set("stop_ratio", 0.025);
  params.Set("unvisited_m2", 2.0);
  params.Set("unvisited_beyond_m", 5.0);
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  const PlanResult far = planner->Plan(kStandAtObject, map, ground);
  ASSERT_EQ(far.outcome, "view");
  for (const Candidate& c : far.candidates) {
    const double beyond = std::max(0.0, 1.0 - 5.0 / (c.p_map - Vec2(0.0, -3.0)).norm());
    EXPECT_NEAR(*c.worth, 2.0 * beyond, 1e-12) << "nothing is unknown";
  }
  for (const Vec2& p : {Vec2(-4, -7), Vec2(4, -7), Vec2(-4, 1), Vec2(4, 1), Vec2(0, 2)}) {
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(p.x(), p.y(), 0.44), 0.0), 100);
  }
  for (const Candidate& c : planner->Plan(kStandAtObject, map, ground).candidates) EXPECT_EQ(c.worth, 0.0);
}

TEST(NbvPlanner, WhereNothingIsPromisedAnyMoreSomeRoundsGoWhereNoScanWasYet) {
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  const PlannerSettings params = SmallPlanner("greedy");
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  ASSERT_EQ(planner->Plan(kStandAtObject, NearSideMapped(), ground).outcome, "view");
  const auto known = NearSideMapped(0.12);
  std::vector<Vec2> scans = {Vec2(0.0, -3.0)};
  for (int round = 1; round < 4; ++round) {
    const PlanResult decision = planner->Plan(kStandAtObject, known, ground);
    ASSERT_EQ(decision.outcome, "view") << round;
    const auto nearest = [&](const Candidate& c) { return DistanceToVisited(c.p_map, scans); };
    const Candidate& view = decision.candidates[static_cast<size_t>(decision.best)];
    for (const Candidate& c : decision.candidates) EXPECT_LE(nearest(c), nearest(view) + 1e-9);
    scans.push_back(view.p_map);
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(view.p_map.x(), view.p_map.y(), 0.44), 0.0), 500);
  }
  EXPECT_EQ(planner->Plan(kStandAtObject, known, ground).outcome, "gain_exhausted");
}

TEST(NbvPlanner, TheElevationMapHoldsAsMuchAsIsPlannedInUnlessTold) {
  const auto terrain_m = [](const std::map<std::string, std::string>& values) {
    return PlannerSettings{.name = "greedy", .values = values}.Load().terrain.window_m;
  };
  EXPECT_EQ(terrain_m({}), 16.0);
  EXPECT_EQ(terrain_m({{"window_m", "20"}}), 20.0);
  EXPECT_EQ(terrain_m({{"window_m", "7"}}), 16.0) << "feet look farther";
  EXPECT_EQ(terrain_m({{"window_m", "20"}, {"terrain.window_m", "10"}}), 10.0);
}

TEST(NbvPlanner, UnknownNamesAreRefused) {
  EXPECT_THROW(StandAtObject({.name = "greeedy", .values = {}}), core::InputError);
  PlannerSettings params;
  params.Set("gain", "entropy_of_everything");
  EXPECT_THROW(StandAtObject(params), core::InputError);
}

}  // namespace
}  // namespace atlas::planner
