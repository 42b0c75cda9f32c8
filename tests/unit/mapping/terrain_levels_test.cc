// Floors above one another: each is answered for by itself, whichever the robot stands on.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/mapping/terrain_fixture.h"

namespace atlas::mapping {
namespace {

using core::Vec2;
using core::Vec3;
using tests::Storeys;

/// Wherever the robot stands, the whole ramp is in it.
constexpr double kWindow_m = 20.0;

/// A walk with a sweep wherever it stops, from the lower floor up the ramp on to the upper one, and back
/// where `back`.
std::unique_ptr<ElevationMap> MapAfterClimb(const Storeys& storeys, bool back) {
  std::vector<Vec3> stands = Storeys::Climb();
  if (back) {
    const std::vector<Vec3> climb = stands;
    stands.insert(stands.end(), climb.rbegin() + 1, climb.rend());
  }
  return MapAfterSweeps(storeys.world, stands, {.seed = 5, .depth_images = 1, .window_m = kWindow_m});
}

class TerrainLevels : public ::testing::TestWithParam<bool> {
 protected:
  static const ElevationMap& Map() {
    static const Storeys storeys;
    static const std::unique_ptr<ElevationMap> up = MapAfterClimb(storeys, false),
                                               down = MapAfterClimb(storeys, true);
    return GetParam() ? *down : *up;
  }
};

TEST_P(TerrainLevels, FloorsAboveOneAnotherAreBothFree) {
  int both = 0;
  for (double x = -1.0; x <= 2.0; x += 0.2) {
    for (double y = -1.0; y <= 1.4; y += 0.2) {
      if (Storeys::NearThings({x, y}, 1.6)) continue;
      ++both;
      EXPECT_TRUE(Map().CircleFree({x, y, 0.0})) << x << " " << y;
      EXPECT_TRUE(Map().CircleFree({x, y, Storeys::kUpper_m})) << x << " " << y;
      EXPECT_NEAR(Map().SurfaceAt({x, y, 0.1}).height_m, 0.0, 0.03) << x << " " << y;
      EXPECT_NEAR(Map().SurfaceAt({x, y, Storeys::kUpper_m - 0.1}).height_m, Storeys::kUpper_m, 0.03);
      EXPECT_EQ(Map().LevelsAt({x, y}).count, 2) << x << " " << y;
    }
  }
  EXPECT_GT(both, 100);
}

TEST_P(TerrainLevels, TheRobotsLevelComesFirst) {
  EXPECT_NEAR(Map().LevelsAt({2.0, 0.0}).front(), GetParam() ? 0.0 : Storeys::kUpper_m, 0.05);
  EXPECT_NEAR(Map().At(2.0, 0.0).height_m, GetParam() ? 0.0 : Storeys::kUpper_m, 0.05);
}

TEST_P(TerrainLevels, AnObstacleBlocksTheFloorThatItStandsOnAlone) {
  const Vec2 p = Storeys::kPost;
  EXPECT_FALSE(Map().CircleFree({p.x(), p.y(), 0.0}));
  EXPECT_NE(Map().KindAt({p.x(), p.y(), 0.0}), GroundKind::kFree);
  EXPECT_TRUE(Map().CircleFree({p.x(), p.y(), Storeys::kUpper_m}));
  EXPECT_TRUE(Map().FootprintFree({p.x(), p.y(), Storeys::kUpper_m}, 0.7));
}

TEST_P(TerrainLevels, AHoleOpensTheFloorThatItIsInAlone) {
  const Vec2 p = Storeys::kHole;
  EXPECT_FALSE(Map().CircleFree({p.x(), p.y(), Storeys::kUpper_m}));
  EXPECT_EQ(Map().KindAt({p.x(), p.y(), Storeys::kUpper_m}), GroundKind::kDrop);
  EXPECT_TRUE(Map().CircleFree({p.x(), p.y(), 0.0}));
  EXPECT_EQ(Map().KindAt({p.x(), p.y(), 0.0}), GroundKind::kFree);
}

TEST_P(TerrainLevels, BetweenFloorsNothingIsKnownAndNothingIsFree) {
  for (const double z : {0.8, 1.5, 2.2, 3.8}) {
    EXPECT_EQ(Map().KindAt({2.0, 0.0, z}), GroundKind::kUnknown) << z;
    EXPECT_EQ(Map().Traversability({2.0, 0.0, z}), 0.0) << z;
    EXPECT_FALSE(Map().CircleFree({2.0, 0.0, z})) << z;
    EXPECT_FALSE(Map().FootprintFree({2.0, 0.0, z}, 0.0)) << z;
    EXPECT_FALSE(Map().OnLevel({2.0, 0.0, z})) << z;
  }
}

TEST_P(TerrainLevels, TheRampJoinsThem) {
  for (double s = 0.0; s <= 1.0; s += 0.05) {
    const Vec3 p = Storeys::OnRamp(s);
    EXPECT_EQ(Map().KindAt(p), GroundKind::kFree) << s;
    EXPECT_TRUE(Map().FootprintFree(p, 0.0)) << s;
  }
}

TEST_P(TerrainLevels, TheUpperFloorEndsWhereItsEdgeIs) {
  for (double x = -1.0; x < 1.6; x += 0.2) {
    EXPECT_FALSE(Map().CircleFree({x, Storeys::kEdge_y + 0.3, Storeys::kUpper_m})) << x;
    EXPECT_TRUE(Map().CircleFree({x, Storeys::kEdge_y - 0.3, 0.0})) << x;
  }
}

INSTANTIATE_TEST_SUITE_P(Climbs, TerrainLevels, ::testing::Values(false, true),
                         [](const auto& info) { return info.param ? "AndComesBack" : "AndStaysUp"; });

}  // namespace
}  // namespace atlas::mapping
