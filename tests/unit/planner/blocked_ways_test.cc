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

}  // namespace
}  // namespace atlas::planner
