#include <gtest/gtest.h>

#include <queue>
#include <set>

#include "planner/views/candidates.h"
#include "planner/views/ompl_bridge.h"
#include "tests/support/flat_ground.h"

namespace atlas::planner {
namespace {

using core::Vec2;

/// A wall with a gap of 1.6 m splits the window.
tests::FlatGround WallWithGap() {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(1.0, -6.0), Vec2(1.3, 2.0));
  ground.AddObstacle(Vec2(1.0, 3.6), Vec2(1.3, 6.0));
  return ground;
}

TEST(CandidateTree, RrtObtainsTheNodesAskedForOnOpenGround) {
  const tests::FlatGround ground;
  const Walkable walkable(ground, Vec2::Zero());
  EXPECT_EQ(RrtCandidates(walkable, 150, 0.6, core::Rng(1)).nodes.size(), 150u);
}

TEST(CandidateTree, EveryRrtNodeStandsFreeAndEveryEdgeIsFree) {
  const auto ground = WallWithGap();
  const Walkable walkable(ground, Vec2::Zero());
  const CandidateTree tree = RrtCandidates(walkable, 150, 0.6, core::Rng(2));
  ASSERT_GT(tree.nodes.size(), 100u);
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    const auto path = tests::Flattened(tree.PathTo(static_cast<int>(i), core::Vec3::Zero()));
    const Vec2 a = path[path.size() - 2], b = path.back();
    EXPECT_LE((b - a).norm(), 0.6 + 1e-9);
    EXPECT_GE(ground.Clearance(b), 0.50);  // the radius less the snap of the memo
    for (double u = 0.0; u <= 1.0; u += 0.1) EXPECT_GE(ground.Clearance(a + u * (b - a)), 0.27);
    double length = 0.0;
    for (size_t k = 1; k < path.size(); ++k) length += (path[k] - path[k - 1]).norm();
    EXPECT_NEAR(tree.nodes[i].path_length_m, length, 1e-9);
  }
}

TEST(CandidateTree, RrtPassesTheGapInAWall) {
  const auto ground = WallWithGap();
  const Walkable walkable(ground, Vec2::Zero());
  int beyond = 0;
  for (const CandidateNode& node : RrtCandidates(walkable, 150, 0.6, core::Rng(3)).nodes)
    beyond += node.p_map.x() > 1.8;
  EXPECT_GT(beyond, 20);
}

TEST(CandidateTree, SameStreamGivesTheSameTreeWhateverWasPlannedBefore) {
  const auto ground = WallWithGap();
  const Walkable walkable(ground, Vec2::Zero());
  const CandidateTree first = RrtCandidates(walkable, 80, 0.6, core::Rng(5));
  RrtCandidates(walkable, 30, 0.6, core::Rng(6));
  const CandidateTree again = RrtCandidates(walkable, 80, 0.6, core::Rng(5));
  ASSERT_EQ(first.nodes.size(), again.nodes.size());
  for (size_t i = 0; i < first.nodes.size(); ++i) EXPECT_EQ(first.nodes[i].p_map, again.nodes[i].p_map);
}

TEST(CandidateTree, WalledInRrtGivesUpAfterItsAttempts) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(-9.0, 0.7), Vec2(9.0, 9.0));
  ground.AddObstacle(Vec2(-9.0, -9.0), Vec2(9.0, -0.7));
  ground.AddObstacle(Vec2(0.7, -9.0), Vec2(9.0, 9.0));
  ground.AddObstacle(Vec2(-9.0, -9.0), Vec2(-0.7, 9.0));
  const Walkable walkable(ground, Vec2::Zero());
  const CandidateTree tree = RrtCandidates(walkable, 500, 0.6, core::Rng(1));
  EXPECT_LT(tree.nodes.size(), 500u);
  EXPECT_EQ(tree.attempts, 500 * 40);
  for (const CandidateNode& node : tree.nodes) EXPECT_LT(node.p_map.norm(), 0.4);
}

TEST(CandidateTree, ARobotTooNearAWallEscapes) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(0.45, -6.0), Vec2(6.0, 6.0));
  const Walkable walkable(ground, Vec2::Zero());
  EXPECT_FALSE(walkable.CanStand(core::Vec3::Zero()));
  EXPECT_GT(RrtCandidates(walkable, 60, 0.6, core::Rng(1)).nodes.size(), 40u);
  EXPECT_GT(LatticeCandidates(walkable, 0.5).nodes.size(), 40u);
}

/// Dijkstra's lengths against plain relaxation until nothing changes.
TEST(CandidateTree, LatticeReachesAllItCanByTheShortestWay) {
  const auto ground = WallWithGap();
  const Vec2 start(0.1, -0.05);
  const Walkable walkable(ground, start);
  const CandidateTree tree = LatticeCandidates(walkable, 0.5);
  std::vector<double> length(tree.nodes.size(), 1e9);
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 0; i < tree.nodes.size(); ++i) {
      const Vec2& p = tree.nodes[i].p_map;
      const auto relax = [&](const Vec2& from, double before, double reach) {
        if ((p - from).cwiseAbs().maxCoeff() > reach || before + (p - from).norm() > length[i] - 1e-9) return;
        if (!walkable.CanStep({from.x(), from.y(), 0.0}, {p.x(), p.y(), 0.0})) return;
        length[i] = before + (p - from).norm();
        changed = true;
      };
      relax(start, 0.0, 1.11);
      for (size_t j = 0; j < tree.nodes.size(); ++j) {
        if (length[j] < 1e9) relax(tree.nodes[j].p_map, length[j], 0.51);
      }
    }
  }
  std::set<std::pair<int, int>> reached;
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    EXPECT_LE(tree.nodes[i].path_length_m, length[i] + 1e-9);
    const Vec2 cell = tree.nodes[i].p_map / 0.5;
    EXPECT_TRUE(reached.emplace(std::lround(cell.x()), std::lround(cell.y())).second)
        << "twice the same place";
  }
  EXPECT_TRUE(reached.contains({8, 0})) << "beyond the wall";
}

/// Every way on the tree is free, and what is not free to turn in is crossed by narrow steps only.
TEST(CandidateTree, LatticeGoesThroughADoorwayBesideItsPlaces) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(1.0, -6.0), Vec2(1.2, 0.78));  // 0.9 m clear about y = 1.23
  ground.AddObstacle(Vec2(1.0, 1.68), Vec2(1.2, 6.0));
  const Walkable walkable(ground, Vec2::Zero());
  const auto beyond = [](const CandidateTree& tree) {
    return std::count_if(tree.nodes.begin(), tree.nodes.end(),
                         [](const CandidateNode& node) { return node.p_map.x() > 1.7; });
  };
  EXPECT_EQ(beyond(LatticeCandidates(walkable, 0.5)), 0);
  const CandidateTree tree = LatticeCandidates(walkable, 0.5, 0.0, FindPassages(walkable, 1.6));
  EXPECT_GT(beyond(tree), 100);
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    const auto path = tests::Flattened(tree.PathTo(static_cast<int>(i), core::Vec3::Zero()));
    const std::vector<size_t> narrow = tree.NarrowSteps(static_cast<int>(i));
    EXPECT_EQ(narrow.size(), tree.nodes[i].p_map.x() > 1.2 ? 1u : 0u);
    double length = 0.0;
    for (size_t k = 1; k < path.size(); ++k) length += (path[k] - path[k - 1]).norm();
    EXPECT_NEAR(tree.nodes[i].path_length_m, length, 1e-9);
    for (const size_t k : narrow) {
      EXPECT_LT(path[k].x(), 1.0);
      EXPECT_GT(path[k + 1].x(), 1.2);
    }
  }
}

TEST(CandidateTree, SpreadOutPicksTheFarthestRemainingPlace) {
  std::vector<CandidateNode> nodes;
  for (int i = 0; i < 40; ++i) nodes.push_back({Vec2(0.3 * (i % 8), 0.4 * (i / 8)), -1, 0.0});
  const std::vector<int> chosen = SpreadOut(nodes, Vec2::Zero(), 12);
  ASSERT_EQ(chosen.size(), 12u);
  std::vector<Vec2> before = {Vec2::Zero()};
  const auto gap = [&](const Vec2& p) {
    double nearest = 1e9;
    for (const Vec2& q : before) nearest = std::min(nearest, (p - q).norm());
    return nearest;
  };
  for (const int i : chosen) {
    double farthest = 0.0;
    for (const CandidateNode& node : nodes) farthest = std::max(farthest, gap(node.p_map));
    EXPECT_NEAR(gap(nodes[static_cast<size_t>(i)].p_map), farthest, 1e-12);
    before.push_back(nodes[static_cast<size_t>(i)].p_map);
  }
  EXPECT_EQ(SpreadOut(nodes, Vec2::Zero(), 100).size(), nodes.size());
}

}  // namespace
}  // namespace atlas::planner
