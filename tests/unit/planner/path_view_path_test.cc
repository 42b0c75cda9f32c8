#include <gtest/gtest.h>

#include "planner/travel/view_path.h"
#include "planner/views/candidates.h"
#include "tests/support/flat_ground.h"

namespace atlas::planner {
namespace {

using core::Vec2;

void ExpectFree(const tests::FlatGround& ground, const std::vector<Vec2>& path) {
  for (size_t i = 1; i < path.size(); ++i) {
    for (double u = 0.0; u <= 1.0; u += 0.02) {
      EXPECT_GE(ground.Clearance(path[i - 1] + u * (path[i] - path[i - 1])), 0.27);
    }
  }
}

std::vector<Vec2> PlannedPath(const Walkable& walkable, const std::vector<Vec2>& tree_path, int iterations,
                              const core::Rng& rng) {
  return tests::Flattened(PlanViewPath(walkable, tests::OnFloor(tree_path), iterations, rng));
}

TEST(ViewPath, OpenGroundIsCrossedStraight) {
  const tests::FlatGround ground;
  const Walkable walkable(ground, Vec2::Zero());
  const std::vector<Vec2> zigzag = {Vec2(0, 0), Vec2(1, 1), Vec2(2, -1), Vec2(4, 0)};
  const auto path = PlannedPath(walkable, zigzag, 500, core::Rng(1));
  ASSERT_EQ(path.size(), 2u);
  EXPECT_NEAR(PathLength(path), 4.0, 1e-12);
}

TEST(ViewPath, RrtStarRoundsACornerNearlyAsShortAsCanBe) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(1.5, -2.0), Vec2(2.5, 1.0));
  const Walkable walkable(ground, Vec2::Zero());
  // A long way round: over the top, wide.
  const std::vector<Vec2> tree_path = {Vec2(0, 0), Vec2(0, 3), Vec2(2, 4), Vec2(4, 3), Vec2(4, 0)};
  const auto path = PlannedPath(walkable, tree_path, 2000, core::Rng(1));
  ExpectFree(ground, path);
  EXPECT_EQ(path.front(), tree_path.front());
  EXPECT_EQ(path.back(), tree_path.back());
  // Waypoints stand 0.55 m off the block: over its two upper corners no way is shorter than this.
  const double shortest = 2.0 * std::hypot(1.5, 1.0 + 0.33) + 1.0;
  EXPECT_GE(PathLength(path), shortest - 0.3);
  EXPECT_LE(PathLength(path), 1.15 * shortest);
}

TEST(ViewPath, WithoutIterationsTheTreePathIsStraightened) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(1.5, -2.0), Vec2(2.5, 1.0));
  const Walkable walkable(ground, Vec2::Zero());
  const std::vector<Vec2> tree_path = {Vec2(0, 0), Vec2(0, 1), Vec2(0, 2),
                                       Vec2(2, 2), Vec2(4, 2), Vec2(4, 0)};
  const auto path = PlannedPath(walkable, tree_path, 0, core::Rng(1));
  ExpectFree(ground, path);
  EXPECT_LT(PathLength(path), PathLength(tree_path));
  for (const Vec2& p : path) EXPECT_NE(std::find(tree_path.begin(), tree_path.end(), p), tree_path.end());
}

TEST(ViewPath, PassagesAreWalkedAsTheyAreAndTheRestIsStraightened) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(1.0, -6.0), Vec2(1.2, 0.78));
  ground.AddObstacle(Vec2(1.0, 1.68), Vec2(1.2, 6.0));
  const Walkable walkable(ground, Vec2::Zero());
  const Vec2 in(0.3, 1.23), out(1.9, 1.23);
  const std::vector<Vec2> tree_path = {Vec2(0, 0), Vec2(0, -1), Vec2(-0.5, 0), in,
                                       out,        Vec2(2, 3),  Vec2(4, 0)};
  const auto path =
      tests::Flattened(PlanViewPath(walkable, tests::OnFloor(tree_path), {3}, 300, core::Rng(2)));
  ExpectFree(ground, path);
  EXPECT_EQ(path.front(), tree_path.front());
  EXPECT_EQ(path.back(), tree_path.back());
  const auto at = std::find(path.begin(), path.end(), in);
  ASSERT_NE(at, path.end());
  EXPECT_EQ(*(at + 1), out);
  EXPECT_LE(path.size(), 5u);
  EXPECT_LT(PathLength(path), PathLength(tree_path) - 2.0);
}

TEST(ViewPath, SameStreamGivesTheSamePath) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(1.5, -2.0), Vec2(2.5, 1.0));
  const Walkable walkable(ground, Vec2::Zero());
  const std::vector<Vec2> tree_path = {Vec2(0, 0), Vec2(0, 3), Vec2(4, 3), Vec2(4, 0)};
  const auto first = PlannedPath(walkable, tree_path, 400, core::Rng(9));
  PlannedPath(walkable, tree_path, 100, core::Rng(3));
  EXPECT_EQ(first, PlannedPath(walkable, tree_path, 400, core::Rng(9)));
}

TEST(ViewPath, StandingAtTheViewNeedsNoPath) {
  const tests::FlatGround ground;
  const Walkable walkable(ground, Vec2::Zero());
  EXPECT_EQ(PlannedPath(walkable, {Vec2::Zero()}, 100, core::Rng(1)).size(), 1u);
}

}  // namespace
}  // namespace atlas::planner
