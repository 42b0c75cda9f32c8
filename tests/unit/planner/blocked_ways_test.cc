// Ways too narrow: found where they are, told from what is merely far, open or unseen.
#include "planner/graph/blocked_ways.h"

#include <gtest/gtest.h>

#include "tests/support/flat_ground.h"
#include "tests/support/moved_keyframes.h"

namespace atlas::planner {
namespace {

using core::Vec2;

/// A wall along y = 2 with a gap of `width_m` about x = 0.7; the robot stands on one side.
tests::FlatGround WallWithGap(double width_m) {
  tests::FlatGround ground(12.0, Vec2(0.0, 0.0));
  ground.AddObstacle(Vec2(-20.0, 2.0), Vec2(0.7 - 0.5 * width_m, 2.2));
  ground.AddObstacle(Vec2(0.7 + 0.5 * width_m, 2.0), Vec2(20.0, 2.2));
  return ground;
}

std::vector<BlockedWay> BlockedIn(const mapping::TraversableGround& ground) {
  const Walkable walkable(ground, Vec2(0.0, 0.0));
  return FindBlockedWays(walkable, LatticeCandidates(walkable, 0.5), Footprint{});
}

/// What a planner knows after one plan there.
BlockedWays KnownAfterAPlanIn(const mapping::TraversableGround& ground) {
  const Walkable walkable(ground, Vec2(0.0, 0.0));
  const CandidateTree tree = LatticeCandidates(walkable, 0.5);
  BlockedWays ways;
  ways.Learn(walkable, tree, FindBlockedWays(walkable, tree, Footprint{}), tests::MovedKeyframes());
  return ways;
}

TEST(BlockedWays, AGapNarrowerThanTheFootprintIsNamedWhereItIs) {
  for (const double width : {0.3, 0.4, 0.5, 0.6}) {
    const std::vector<BlockedWay> ways = BlockedIn(WallWithGap(width));
    ASSERT_EQ(ways.size(), 1u) << width;
    EXPECT_LT((ways[0].p_map - Vec2(0.7, 2.1)).norm(), 0.2) << width;
    EXPECT_NEAR(ways[0].width_m, width, 0.06);
    EXPECT_NEAR(ways[0].needed_m, 0.66, 1e-9);
    ASSERT_FALSE(ways[0].beyond_map.empty());
    for (const core::Vec3& p : ways[0].beyond_map) EXPECT_GT(p.y(), 2.2);
  }
}

TEST(BlockedWays, AGapThatTheRobotPassesIsNone) {
  EXPECT_TRUE(BlockedIn(WallWithGap(1.3)).empty());
}

TEST(BlockedWays, AWallWithoutAGapIsNone) {
  tests::FlatGround ground(12.0, Vec2(0.0, 0.0));
  ground.AddObstacle(Vec2(-20.0, 2.0), Vec2(20.0, 2.2));
  EXPECT_TRUE(BlockedIn(ground).empty());
}

TEST(BlockedWays, ACorridorInWhichItCannotTurnIsNamedByTheTurningCircle) {
  tests::FlatGround ground(12.0, Vec2(0.0, 0.0));
  ground.AddObstacle(Vec2(-20.0, 2.0), Vec2(0.25, 5.0));
  ground.AddObstacle(Vec2(1.15, 2.0), Vec2(20.0, 5.0));  // 0.9 m wide, 3 m long
  const std::vector<BlockedWay> ways = BlockedIn(ground);
  ASSERT_EQ(ways.size(), 1u);
  EXPECT_NEAR(ways[0].p_map.x(), 0.7, 0.1);
  EXPECT_NEAR(ways[0].width_m, 0.9, 0.06);
  EXPECT_NEAR(ways[0].needed_m, 1.1, 1e-9);
}

TEST(BlockedWays, TwoGapsAreTwoWays) {
  tests::FlatGround ground(12.0, Vec2(0.0, 0.0));
  ground.AddObstacle(Vec2(-20.0, 2.0), Vec2(0.5, 2.2));
  ground.AddObstacle(Vec2(0.9, 2.0), Vec2(20.0, 2.2));
  ground.AddObstacle(Vec2(-20.0, -2.2), Vec2(-1.3, -2.0));
  ground.AddObstacle(Vec2(-0.9, -2.2), Vec2(20.0, -2.0));
  EXPECT_EQ(BlockedIn(ground).size(), 2u);
}

TEST(BlockedWays, AreWorthTheBestViewBeyondThemOnceJudged) {
  BlockedWays ways = KnownAfterAPlanIn(WallWithGap(0.4));
  ASSERT_EQ(ways.ways().size(), 1u);
  EXPECT_FALSE(ways.ways()[0].worth_share.has_value());
  std::vector<double> shares(ways.PlacesBeyond().size(), 0.0);
  ways.SetWorth(shares, 0.5);
  EXPECT_EQ(ways.ways()[0].worth_share, 0.0);
  EXPECT_FALSE(ways.ways()[0].promises);
  shares.back() = 0.3;
  ways.SetWorth(shares, 0.5);
  EXPECT_EQ(ways.ways()[0].worth_share, 0.3);
  EXPECT_FALSE(ways.ways()[0].promises);
  ways.SetWorth(shares, 0.3);
  EXPECT_TRUE(ways.ways()[0].promises);
}

TEST(BlockedWays, AreKeptBeyondTheWindowAndForgottenWhereTheFarSideIsReached) {
  BlockedWays ways = KnownAfterAPlanIn(WallWithGap(0.4));
  ASSERT_EQ(ways.ways().size(), 1u);

  const Vec2 elsewhere(0.0, -20.0);
  const tests::FlatGround far(12.0, elsewhere);
  const Walkable there(far, elsewhere);
  ways.Learn(there, LatticeCandidates(there, 0.5), {}, tests::MovedKeyframes());
  EXPECT_EQ(ways.ways().size(), 1u) << "out of sight";
  CandidateTree beyond;
  for (const core::Vec3& p : ways.PlacesBeyond()) beyond.nodes.push_back({.p_map = p.head<2>()});
  ways.Learn(there, beyond, {}, tests::MovedKeyframes());
  EXPECT_TRUE(ways.ways().empty()) << "another way led there";
}

/// Counts how often it is asked what costs most.
class CountingGround : public tests::FlatGround {
 public:
  using tests::FlatGround::FlatGround;
  bool CircleFree(const core::Vec3& p) const override {
    ++asked;
    return tests::FlatGround::CircleFree(p);
  }
  mutable int asked = 0;
};

TEST(BlockedWays, NoCellIsAskedTwiceWhetherTheRobotFitsThere) {
  CountingGround ground(12.0, Vec2(0.0, 0.0));
  ground.AddObstacle(Vec2(-20.0, 2.0), Vec2(20.0, 2.2));
  const Walkable walkable(ground, Vec2(0.0, 0.0));
  ground.asked = 0;
  FindBlockedWays(walkable, {}, Footprint{});
  EXPECT_GT(ground.asked, 1000);
  EXPECT_LE(ground.asked, 240 * 240) << "cells of 5 cm in 12 m";
}

/// A way at (2, 0), the ground beyond it at (3, 0) on a floor of this height.
BlockedWay WayAtTwo(double floor_m = 0.0) {
  BlockedWay way;
  way.p_map = Vec2(2.0, 0.0);
  way.width_m = 0.5;
  way.needed_m = 0.66;
  way.beyond_map = {core::Vec3(3.0, 0.0, floor_m)};
  return way;
}

/// Plans 30 m away, whose window does not hold the way: with these keyframes.
void PlanFarAway(BlockedWays* ways, const tests::MovedKeyframes& keyframes, const CandidateTree& tree = {}) {
  const Vec2 elsewhere(30.0, 0.0);
  const tests::FlatGround ground(4.0, elsewhere);
  ways->Learn(Walkable(ground, elsewhere), tree, {}, keyframes);
}

TEST(BlockedWays, MoveWithTheKeyframesThatTheyWereFoundFromAndWithNoOther) {
  const core::Pose first = core::Pose::Identity(), second = core::PoseFromXyzYaw({30.0, 0.0, 0.0}, 0.0);
  const tests::FlatGround ground(8.0);
  BlockedWays ways;
  ways.Learn(Walkable(ground, Vec2(0.0, 0.0)), {}, {WayAtTwo()}, tests::MovedKeyframes({first}));
  PlanFarAway(&ways, tests::MovedKeyframes({first, second}));

  const core::Pose second_moved = core::PoseFromXyzYaw({30.0, 1.0, 0.0}, 0.1);
  PlanFarAway(&ways, tests::MovedKeyframes({first, second_moved}, 1));
  ASSERT_EQ(ways.ways().size(), 1u);
  EXPECT_LT((ways.ways()[0].p_map - Vec2(2.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((ways.PlacesBeyond()[0] - core::Vec3(3.0, 0.0, 0.0)).norm(), 1e-9);

  const core::Pose first_moved = core::PoseFromXyzYaw({0.0, 0.0, 0.5}, 0.5 * core::kPi);
  PlanFarAway(&ways, tests::MovedKeyframes({first_moved, second_moved}, 2));
  ASSERT_EQ(ways.ways().size(), 1u);
  EXPECT_LT((ways.ways()[0].p_map - Vec2(0.0, 2.0)).norm(), 1e-9);
  EXPECT_LT((ways.PlacesBeyond()[0] - core::Vec3(0.0, 3.0, 0.5)).norm(), 1e-9);
}

TEST(BlockedWays, APointThatIsSeenAgainLeavesTheOthersWithTheirKeyframe) {
  const core::Pose first = core::Pose::Identity(), second = core::PoseFromXyzYaw({30.0, 0.0, 0.0}, 0.0);
  BlockedWay of_two = WayAtTwo();
  of_two.beyond_map = {core::Vec3(3.0, 0.0, 0.0), core::Vec3(3.0, 40.0, 0.0)};
  const tests::FlatGround ground(8.0);
  const Walkable here(ground, Vec2(0.0, 0.0));
  BlockedWays ways;
  ways.Learn(here, {}, {of_two}, tests::MovedKeyframes({first}));
  ways.Learn(here, {}, {WayAtTwo()}, tests::MovedKeyframes({first, second}));  // (3, 0) anew
  PlanFarAway(&ways, tests::MovedKeyframes({core::PoseFromXyzYaw({0.0, 5.0, 0.0}, 0.0), second}, 1));
  ASSERT_EQ(ways.ways().size(), 1u);
  EXPECT_LT((ways.ways()[0].p_map - Vec2(2.0, 0.0)).norm(), 1e-9);
  ASSERT_EQ(ways.PlacesBeyond().size(), 2u);
  EXPECT_LT((ways.PlacesBeyond()[0] - core::Vec3(3.0, 0.0, 0.0)).norm(), 1e-9);
  EXPECT_LT((ways.PlacesBeyond()[1] - core::Vec3(3.0, 45.0, 0.0)).norm(), 1e-9);
}

TEST(BlockedWays, OfAFloorAboveStayWhenThePlanIsUnderThem) {
  const tests::FlatGround ground(8.0);
  const Walkable below(ground, Vec2(0.0, 0.0));
  BlockedWays ways;
  ways.Learn(below, {}, {WayAtTwo(3.0)}, tests::MovedKeyframes());
  ways.Learn(below, {}, {}, tests::MovedKeyframes());
  EXPECT_EQ(ways.ways().size(), 1u) << "the window holds (x, y), but another floor of it";

  BlockedWays on_this_floor;
  on_this_floor.Learn(below, {}, {WayAtTwo(0.0)}, tests::MovedKeyframes());
  on_this_floor.Learn(below, {}, {}, tests::MovedKeyframes());
  EXPECT_TRUE(on_this_floor.ways().empty()) << "looked at anew, and not found";
}

TEST(BlockedWays, AreNotReachedByAPlaceOfAnotherFloor) {
  const tests::FlatGround ground(8.0);
  BlockedWays ways;
  ways.Learn(Walkable(ground, Vec2(0.0, 0.0)), {}, {WayAtTwo(3.0)}, tests::MovedKeyframes());
  CandidateTree tree;
  tree.nodes.push_back({.p_map = Vec2(3.0, 0.0), .ground_m = 0.0});
  PlanFarAway(&ways, tests::MovedKeyframes(), tree);
  EXPECT_EQ(ways.ways().size(), 1u) << "beneath it";
  tree.nodes.push_back({.p_map = Vec2(3.0, 0.0), .ground_m = 3.0});
  PlanFarAway(&ways, tests::MovedKeyframes(), tree);
  EXPECT_TRUE(ways.ways().empty()) << "there";
}

}  // namespace
}  // namespace atlas::planner
