#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planner/travel/costs.h"
#include "tests/support/side_mapped_object.h"

namespace atlas::planner {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;
using namespace tests;

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
    for (const Candidate& c : second.candidates) best = std::max(best, *c.utility);
    return best;
  }();
  const bool same_place = (kept.p_map - view.p_map).norm() < 0.5;
  EXPECT_TRUE(same_place || kept.utility == best_utility);
  EXPECT_GE(*kept.utility * 1.151, best_utility);
}

/// Of two views that promise alike, the one that the robot set out for; a margin says how much better another
/// must be.
TEST(NbvPlanner, ACommitmentYieldsToAViewThatIsBetterByTheMarginOnly) {
  const auto map = NearSideMapped();
  int kept = 0, turned = 0;
  for (const double margin : {10.0, 0.0}) {
    for (const Vec2& on_the_way :
         {Vec2(0.3, -2.8), Vec2(1.5, -3.0), Vec2(-1.5, -3.0), Vec2(2.5, -2.0), Vec2(-2.5, -2.0)}) {
      PlannerSettings params = SmallPlanner("greedy");
      params.Set("commit_margin", margin);
      params.Set("nodes", 600);  // every place of the lattice, whichever the robot stands at
      params.Set("rays", 100);
      const auto planner = StandAtObject(params);
      planner->OnSweep(kStandAtObject, 500);
      const PlanResult first = planner->Plan(kStandAtObject, map, GroundAboutObject(Vec2(0.0, -3.0)));
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
  PlannerSettings params = SmallPlanner("greedy");
  params.Set("distrust_m", 0.0);
  params.Set("visited_cost", false);
  params.Set("flat_rounds", 100);
  const auto planner = StandAtObject(params);
  planner->OnSweep(kStandAtObject, 500);
  std::vector<Vec2> chosen;
  for (int i = 0; i < 3; ++i) {
    const PlanResult decision = planner->Plan(kStandAtObject, map, ground);
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

  planner->OnSweep(kStandAtObject, 0);
  const PlanResult turn = planner->Plan(kStandAtObject, map, nothing);
  EXPECT_EQ(turn.path_map, std::vector<Vec2>{Vec2(0.0, -3.0)}) << "not back again";
  planner->OnSweep(kStandAtObject, 0);
  EXPECT_EQ(planner->Plan(kStandAtObject, map, nothing).outcome, "no_candidates");
}

TEST(NbvPlanner, ViewsAboutABrokenPromiseAreWorthLess) {
  const auto map = NearSideMapped();
  const auto ground = GroundAboutObject(Vec2(0.0, -3.0));
  std::vector<std::vector<Candidate>> by_distrust;
  Vec2 broken = Vec2::Zero();
  for (const double distrust_m : {0.0, 4.0}) {
    PlannerSettings params = SmallPlanner("greedy");
    params.Set("distrust_m", distrust_m);
    const auto planner = StandAtObject(params);
    planner->OnSweep(kStandAtObject, 500);
    const PlanResult first = planner->Plan(kStandAtObject, map, ground);
    ASSERT_EQ(first.outcome, "view");
    broken = first.candidates[static_cast<size_t>(first.best)].p_map;
    planner->OnSweep(core::PoseFromXyzYaw(Vec3(broken.x(), broken.y(), 0.44), 0.0), 0);
    by_distrust.push_back(planner->Plan(kStandAtObject, map, ground).candidates);
  }
  ASSERT_EQ(by_distrust[0].size(), by_distrust[1].size());
  int less = 0;
  for (size_t i = 0; i < by_distrust[0].size(); ++i) {
    const Candidate &whole = by_distrust[0][i], &doubted = by_distrust[1][i];
    ASSERT_EQ(whole.p_map, doubted.p_map);
    const double trust = 1.0 - std::exp(-(whole.p_map - broken).squaredNorm() / 16.0);
    EXPECT_NEAR(*doubted.worth, *whole.worth * trust, 1e-9);
    less += *doubted.worth < 0.5 * *whole.worth;
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
  PlannerSettings params = SmallPlanner("greedy");
  for (const double side : {4.0, 30.0}) {
    params.Set("window_m", side);
    const auto planner = StandAtObject(params);
    planner->OnSweep(kStandAtObject, 500);
    double farthest = 0.0;
    for (const Candidate& c :
         planner->Plan(kStandAtObject, map, GroundAboutObject(Vec2(0.0, -3.0))).candidates) {
      farthest = std::max(farthest, (c.p_map - Vec2(0.0, -3.0)).cwiseAbs().maxCoeff());
    }
    EXPECT_NEAR(farthest, 0.5 * std::min(side, 12.0), 0.5);
  }
}

}  // namespace
}  // namespace atlas::planner
