#include "planner/views/passages.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.h"
#include "tests/support/flat_ground.h"

namespace atlas::planner {
namespace {

using core::Vec2;

/// A wall 0.2 m thick across y = `y_m` with gaps about these places, alternately x and width.
void AddWall(double y_m, const std::vector<std::pair<double, double>>& gaps, tests::FlatGround* ground) {
  double from = -9.0;
  for (const auto& [x, width] : gaps) {
    ground->AddObstacle(Vec2(from, y_m), Vec2(x - 0.5 * width, y_m + 0.2));
    from = x + 0.5 * width;
  }
  ground->AddObstacle(Vec2(from, y_m), Vec2(9.0, y_m + 0.2));
}

TEST(Passages, ADoorwayAnywhereIsPassedInItsMiddleAndSquare) {
  core::Rng rng(4);
  for (int k = 0; k < 12; ++k) {
    const double x = rng.Uniform(-2.0, 2.0), y = rng.Uniform(1.0, 2.0), width = rng.Uniform(0.8, 1.05);
    tests::FlatGround ground(8.0);
    AddWall(y, {{x, width}}, &ground);
    const Walkable walkable(ground, Vec2::Zero());
    const std::vector<Passage> passages = FindPassages(walkable, 1.6);
    ASSERT_EQ(passages.size(), 1u) << x << " " << y << " " << width;
    const core::Vec3 a = passages[0].a, b = passages[0].b;
    EXPECT_NEAR(a.x(), x, 0.03);
    EXPECT_NEAR(b.x(), x, 0.03);
    EXPECT_LT(std::min(a.y(), b.y()), y);
    EXPECT_GT(std::max(a.y(), b.y()), y + 0.2);
    EXPECT_TRUE(walkable.CanStand(a) && walkable.CanStand(b));
    EXPECT_TRUE(walkable.CanStep(a, b));
    EXPECT_NEAR(passages[0].clearance_m, 0.5 * width - 0.33, 0.04);
    for (double u = 0.0; u <= 1.0; u += 0.02) {
      EXPECT_GT(ground.Clearance((a + u * (b - a)).head<2>()), 0.5 * width - 0.04);
    }
  }
}

TEST(Passages, EveryDoorwayHasOneAndOnlyDoorwaysHave) {
  tests::FlatGround ground;
  // Too narrow to walk, two doorways, and below a wall with an opening wide enough to turn in.
  AddWall(1.5, {{-4.0, 0.6}, {-1.63, 0.9}, {1.88, 0.95}}, &ground);
  AddWall(-2.5, {{1.0, 1.6}}, &ground);
  const Walkable walkable(ground, Vec2::Zero());
  std::vector<Passage> passages = FindPassages(walkable, 1.6);
  ASSERT_EQ(passages.size(), 2u);
  std::sort(passages.begin(), passages.end(),
            [](const Passage& p, const Passage& q) { return p.a.x() < q.a.x(); });
  EXPECT_NEAR(passages[0].a.x(), -1.63, 0.03);
  EXPECT_NEAR(passages[1].a.x(), 1.88, 0.03);
}

TEST(Passages, AWayOfOneCellIsFoundWhereverItLies) {
  // Little more room than the footprint's width: 3 cm to place its middle in.
  core::Rng rng(6);
  for (int k = 0; k < 40; ++k) {
    const double x = rng.Uniform(-2.0, 2.0), y = rng.Uniform(1.0, 2.0);
    tests::FlatGround ground(8.0);
    AddWall(y, {{x, 0.7}}, &ground);
    const std::vector<Passage> passages = FindPassages(Walkable(ground, Vec2::Zero()), 1.6);
    ASSERT_EQ(passages.size(), 1u) << x << " " << y;
    EXPECT_NEAR(passages[0].a.x(), x, 0.03);
    EXPECT_NEAR(passages[0].b.x(), x, 0.03);
  }
}

TEST(Passages, LongerThanAskedForIsNoPassage) {
  tests::FlatGround ground;
  ground.AddObstacle(Vec2(-9.0, 1.0), Vec2(-0.45, 2.5));
  ground.AddObstacle(Vec2(0.45, 1.0), Vec2(9.0, 2.5));
  const Walkable walkable(ground, Vec2::Zero());
  EXPECT_TRUE(FindPassages(walkable, 1.6).empty());
  EXPECT_EQ(FindPassages(walkable, 3.0).size(), 1u);
}

TEST(Passages, OpenGroundHasNone) {
  const tests::FlatGround ground;
  EXPECT_TRUE(FindPassages(Walkable(ground, Vec2::Zero()), 1.6).empty());
}

}  // namespace
}  // namespace atlas::planner
