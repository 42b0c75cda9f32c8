// Kerbs, steps, ramps and things overhead.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/mapping/terrain_fixture.h"

namespace atlas::mapping {
namespace {

using core::Radians;
using core::Vec3;
using tests::PatchWorld;

std::unique_ptr<ElevationMap> MapOf(const PatchWorld& world, const std::vector<Vec3>& stands) {
  return MapAfterSweeps(world, stands, {.seed = 11});
}

/// Ground at 0 for x < edge_x and at `rise_m` beyond, with the riser between.
PatchWorld StepWorld(double edge_x, double rise_m) {
  PatchWorld world;
  world.AddRectangle(-20, -20, edge_x, 20, 0);
  world.AddRectangle(edge_x, -20, 20, 20, rise_m);
  world.patches.push_back({{edge_x, -20, 0}, {0, 40, 0}, {0, 0, rise_m}});
  return world;
}

TEST(TerrainObstacles, KerbOfTenCentimetresHasItsHeightAndMayBeClimbedAtACost) {
  const auto map = MapOf(StepWorld(1.6, 0.10), {{0, 0, 0}});
  for (double y = -1.0; y <= 1.0; y += 0.2) {
    EXPECT_NEAR(map->At(1.4, y).height_m, 0.0, 0.015) << y;
    EXPECT_NEAR(map->At(1.8, y).height_m, 0.1, 0.015) << y;
    EXPECT_GT(map->Traversability({1.6, y, 0.0}), 0.25) << y;
    EXPECT_LT(map->Traversability({1.6, y, 0.0}), 0.75) << y;
    EXPECT_TRUE(map->CircleFree({1.6, y, 0.0})) << y;
    EXPECT_FALSE(map->At(1.61, y).steppable) << y;
    EXPECT_TRUE(map->At(1.8, y).steppable) << y;
  }
}

TEST(TerrainObstacles, BarTenCentimetresHighSeenFromBothSidesIsNoKerb) {
  PatchWorld world = FlatWorld();
  world.AddBox({1.6, -3.0, 0}, {1.72, 3.0, 0.10});
  const auto map = MapOf(world, {{3.3, 0, 0}, {0, 0, 0}});
  for (double y = -1.0; y <= 1.0; y += 0.2) {
    EXPECT_EQ(map->Traversability({1.66, y, 0.0}), 0.0) << y;
    EXPECT_FALSE(map->CircleFree({1.66, y, 0.0})) << y;
    EXPECT_TRUE(map->CircleFree({0.6, y, 0.0})) << y;
  }
}

TEST(TerrainObstacles, StepOfThirtyCentimetresBlocks) {
  const auto map = MapOf(StepWorld(1.6, 0.30), {{0, 0, 0}});
  for (double y = -2.0; y <= 2.0; y += 0.2) {
    double least = 1.0;
    for (double x = 1.4; x < 1.8; x += 0.02) least = std::min(least, map->Traversability({x, y, 0.0}));
    EXPECT_EQ(least, 0.0) << y;
    EXPECT_FALSE(map->CircleFree({1.3, y, 0.0})) << y;
    EXPECT_EQ(map->Traversability({2.2, y, 0.3}), 0.0) << "a platform that nothing leads to";
  }
}

TEST(TerrainObstacles, StepDownOfThirtyCentimetresBlocks) {
  const auto map = MapOf(StepWorld(1.6, -0.30), {{0, 0, 0}});
  for (double y = -2.0; y <= 2.0; y += 0.2) {
    EXPECT_FALSE(map->CircleFree({1.3, y, 0.0})) << y;
    EXPECT_FALSE(map->At(1.64, y).steppable) << y;
    EXPECT_EQ(map->Traversability({1.66, y, 0.0}), 0.0) << y;
  }
}

TEST(TerrainObstacles, RampOfTenDegreesIsMeasuredWithinADegree) {
  PatchWorld world;
  const double rise = std::tan(Radians(10.0));
  world.AddRectangle(-20, -20, 1.5, 20, 0);
  world.patches.push_back({{1.5, -20, 0}, {0, 40, 0}, {5, 0, 5 * rise}});
  const auto map = MapOf(world, {{0, 0, 0}});
  for (double x = 2.0; x < 4.0; x += 0.25) {
    for (double y = -1.5; y <= 1.5; y += 0.5) {
      const auto surface = map->SurfaceAt({x, y, (x - 1.5) * rise});
      EXPECT_NEAR(core::Degrees(surface.slope_rad), 10.0, 1.0) << x << " " << y;
      EXPECT_NEAR(surface.height_m, (x - 1.5) * rise, 0.02) << x << " " << y;
      EXPECT_GT(map->Traversability({x, y, (x - 1.5) * rise}), 0.6) << x << " " << y;
      EXPECT_TRUE(map->At(x, y).steppable) << x << " " << y;
    }
  }
}

TEST(TerrainObstacles, ArchAboveTheRobotIsNeitherGroundNorObstacle) {
  PatchWorld world = FlatWorld();
  world.AddBox({2.0, -1.2, 1.6}, {2.8, 1.2, 2.0});
  world.AddBox({2.0, 1.0, 0}, {2.8, 1.2, 1.6});
  world.AddBox({2.0, -1.2, 0}, {2.8, -1.0, 1.6});
  const auto map = MapOf(world, {{0, 0, 0}});
  for (double x = 1.2; x < 3.6; x += 0.1) {
    EXPECT_TRUE(map->FootprintFree({x, 0.0, 0.0}, 0.0)) << x;
    EXPECT_NEAR(map->At(x, 0.0).height_m, 0.0, 0.02) << x;
  }
  EXPECT_FALSE(map->FootprintFree({2.4, 0.9, 0.0}, 0.0));
}

TEST(TerrainObstacles, TableBlocksOverItsWholeAreaThoughTheFloorBelowIsSeen) {
  PatchWorld world = FlatWorld();
  world.AddBox({1.8, -0.6, 0.57}, {3.0, 0.6, 0.60});
  const auto map = MapOf(world, {{0, 0, 0}, {1.2, -2.0, 0}});
  for (double x = 1.8; x < 3.0; x += 0.1) {
    for (double y = -0.5; y <= 0.5; y += 0.1)
      EXPECT_FALSE(map->FootprintFree({x, y, 0.0}, 0.0)) << x << " " << y;
  }
  EXPECT_TRUE(map->FootprintFree({1.0, 0.0, 0.0}, 0.0));
}

TEST(TerrainObstacles, SpaceBelowALowBellyIsNotFreeBeforeItWasLookedInto) {
  PatchWorld world = FlatWorld();
  world.AddBox({2.0, -1.5, 0.5}, {5.0, 1.5, 2.2});
  const auto map = MapOf(world, {{0, 0, 0}});
  EXPECT_TRUE(map->At(2.6, 0.0).known);
  for (double x = 2.3; x < 4.8; x += 0.1) {
    for (double y = -1.2; y <= 1.2; y += 0.1) {
      EXPECT_FALSE(map->FootprintFree({x, y, 0.0}, 0.0)) << x << " " << y;
      EXPECT_FALSE(map->CircleFree({x, y, 0.0})) << x << " " << y;
    }
  }
}

TEST(TerrainObstacles, RailsBlockWhereTheyStandAndNotBeside) {
  PatchWorld world = FlatWorld();
  world.AddBox({2.0, -4, 0.48}, {2.05, 4, 0.53});
  world.AddBox({2.0, -4, 1.07}, {2.05, 4, 1.12});
  const auto map = MapOf(world, {{0, 0, 0}, {0.8, 1.0, 0}});
  for (double y = -1.5; y <= 1.5; y += 0.1) {
    EXPECT_FALSE(map->CircleFree({1.9, y, 0.0})) << y;
    EXPECT_FALSE(map->CircleFree({2.3, y, 0.0})) << y;
    EXPECT_TRUE(map->CircleFree({1.3, y, 0.0})) << y;
  }
}

}  // namespace
}  // namespace atlas::mapping
