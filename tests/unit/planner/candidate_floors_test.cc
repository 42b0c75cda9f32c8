// Places and ways over floors that lie above one another.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "planner/travel/view_path.h"
#include "planner/views/candidates.h"

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

/// A lower floor, an upper one 3 m above most of it, and a ramp that ends beside it:
///
///     4  +---------------------------+
///        |  upper floor, z = 3       |      the lower floor, z = 0, is everywhere but under the ramp
///  -0.5  +------------------+        |
///  -1.4  +---- ramp up -> --+        |
///  -3.0  +------------------+--------+
///       -4                  4        6
class TwoFloors final : public mapping::TraversableGround {
 public:
  Levels LevelsAt(const Vec2& p) const override {
    Levels levels;
    if (std::abs(p.x()) > 6.0 || std::abs(p.y()) > 6.0) return levels;
    const bool on_ramp = In(p, {-4, -3}, {4, -1.4});
    if (!on_ramp) levels.Add(0.0);
    if (on_ramp) levels.Add(3.0 * (p.x() + 4.0) / 8.0);
    if (In(p, {-4, -0.5}, {6, 4}) || In(p, {4, -3}, {6, 4})) levels.Add(3.0);
    return levels;
  }
  double Traversability(const Vec3& p) const override { return OnLevel(p) ? 1.0 : 0.0; }
  mapping::GroundKind KindAt(const Vec3& p) const override {
    return OnLevel(p) ? mapping::GroundKind::kFree : mapping::GroundKind::kUnknown;
  }
  bool FootprintFree(const Vec3& p, double) const override { return DiscOnLevel(p, 0.33); }
  bool CircleFree(const Vec3& p) const override { return DiscOnLevel(p, 0.5); }
  Surface SurfaceAt(const Vec3& p) const override { return {OnLevel(p).value_or(p).z(), 0.0, 0.0}; }
  core::Box3 Window() const override { return {Vec3(-6, -6, -4), Vec3(6, 6, 4)}; }

 private:
  static bool In(const Vec2& p, const Vec2& min, const Vec2& max) {
    return (p.array() >= min.array()).all() && (p.array() <= max.array()).all();
  }
  bool DiscOnLevel(const Vec3& p, double radius_m) const {
    const auto centre = OnLevel(p);
    for (int k = 0; centre && k < 16; ++k) {
      const double angle = k * core::kPi / 8.0;
      const Vec3 rim = *centre + radius_m * Vec3(std::cos(angle), std::sin(angle), 0.0);
      if (!OnLevel(rim, 0.3)) return false;
    }
    return centre.has_value();
  }
};

/// No step is steeper than the ramp.
void ExpectOnGround(const std::vector<Vec3>& way) {
  for (size_t i = 1; i < way.size(); ++i) {
    const double rise = std::abs(way[i].z() - way[i - 1].z());
    EXPECT_LE(rise, 3.0 / 8.0 * (way[i] - way[i - 1]).head<2>().norm() + 0.02) << way[i].transpose();
  }
}

std::vector<size_t> NodesAt(const CandidateTree& tree, const Vec2& p) {
  std::vector<size_t> found;
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    if ((tree.nodes[i].p_map - p).norm() < 1e-9) found.push_back(i);
  }
  return found;
}

TEST(CandidateFloors, TheGroundIsFollowedOnTheFloorWhereAStepBegins) {
  const TwoFloors ground;
  const Walkable walkable(ground, Vec2(0, 2));
  EXPECT_EQ(walkable.FollowGround({0, 2, 0}, {1, 2}).value(), Vec3(1, 2, 0));
  EXPECT_EQ(walkable.FollowGround({0, 2, 3}, {1, 2}).value(), Vec3(1, 2, 3));
  EXPECT_LT((walkable.FollowGround({-3.9, -2, 0.0375}, {5, -2}).value() - Vec3(5, -2, 3)).norm(), 1e-9);
  EXPECT_FALSE(walkable.FollowGround({5, -2, 3}, {5, -5})) << "over the edge";
  EXPECT_TRUE(walkable.CanStep({0, 2, 3}, {1, 2, 3}));
  EXPECT_FALSE(walkable.CanStep({0, 2, 0}, {1, 2, 3})) << "through the ceiling";
  EXPECT_TRUE(walkable.CanStand({1, -0.7, 0}));
  EXPECT_FALSE(walkable.CanStand({1, -0.7, 3}));
}

TEST(CandidateFloors, TheLatticeHasPlacesOnBothFloorsAndTheirWaysGoByTheRamp) {
  const TwoFloors ground;
  const Walkable walkable(ground, Vec2(0, 2));
  const CandidateTree tree = LatticeCandidates(walkable, 0.5);
  for (const Vec2& p : {Vec2(1, 2), Vec2(-2, 1), Vec2(3, 3)}) {
    const std::vector<size_t> at = NodesAt(tree, p);
    ASSERT_EQ(at.size(), 2u) << p.transpose();
    EXPECT_NEAR(tree.nodes[at[0]].ground_m, 0.0, 1e-9);  // nearer, so first
    EXPECT_NEAR(tree.nodes[at[1]].ground_m, 3.0, 1e-9);
    const std::vector<Vec3> way = tree.PathTo(static_cast<int>(at[1]), walkable.start());
    ExpectOnGround(way);
    EXPECT_TRUE(
        std::any_of(way.begin(), way.end(), [](const Vec3& q) { return q.z() > 1.2 && q.z() < 1.8; }));
  }
}

TEST(CandidateFloors, ARandomTreeStaysOnTheGroundThatItsStepsFollow) {
  const TwoFloors ground;
  const Walkable walkable(ground, Vec2(0, 2));
  const CandidateTree tree = RrtCandidates(walkable, 300, 0.6, core::Rng(4));
  ASSERT_GT(tree.nodes.size(), 100u);
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    ExpectOnGround(tree.PathTo(static_cast<int>(i), walkable.start()));
  }
}

TEST(CandidateFloors, ViewPathsToTheFloorAboveStayOnGround) {
  const TwoFloors ground;
  const Walkable walkable(ground, Vec2(0, 2));
  const CandidateTree tree = LatticeCandidates(walkable, 0.5);
  const std::vector<size_t> at = NodesAt(tree, {1, 2});
  ASSERT_EQ(at.size(), 2u);
  const std::vector<Vec3> tree_path = tree.PathTo(static_cast<int>(at[1]), walkable.start());
  const std::vector<Vec3> way = PlanViewPath(walkable, tree_path, 600, core::Rng(5));
  EXPECT_EQ(way.front(), tree_path.front());
  EXPECT_EQ(way.back(), tree_path.back());
  EXPECT_GT(PathLength(way), 10.0) << "there is no other way than the ramp";
  EXPECT_LE(PathLength(way), PathLength(tree_path) + 1e-9);
  for (size_t i = 1; i < way.size(); ++i) EXPECT_TRUE(walkable.CanStep(way[i - 1], way[i])) << i;
}

}  // namespace
}  // namespace atlas::planner
