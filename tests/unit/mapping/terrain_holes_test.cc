// Deck edges, stairwells and gratings: what must never be walked on, and what must be.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/mapping/terrain_fixture.h"

namespace atlas::mapping {
namespace {

using core::Vec2;
using core::Vec3;
using tests::PatchWorld;

constexpr double kCell = 0.04;

/// A deck 3 m above the floor, 10 x 7 m, with a stairwell of 1 x 2.5 m.
struct Deck {
  core::Box3 plate, hole;
  PatchWorld world;

  explicit Deck(double transmission) {
    plate.min = Vec3(-4, -3, 0);
    plate.max = Vec3(6, 4, 0);
    hole.min = Vec3(1.51, -1.22, 0);
    hole.max = Vec3(2.51, 1.28, 0);
    world.AddRectangle(-30, -30, 30, 30, -3);
    world.AddPlateWithHole(plate.min.x(), plate.min.y(), plate.max.x(), plate.max.y(), 0, hole, transmission);
  }
  /// Metres from `p` to the nearest place without deck; negative off the deck.
  double Margin(const Vec2& p) const {
    const auto inside = [&](const core::Box3& box) {
      return std::min(std::min(p.x() - box.min.x(), box.max.x() - p.x()),
                      std::min(p.y() - box.min.y(), box.max.y() - p.y()));
    };
    const double from_hole = inside(hole);
    if (from_hole >= 0) return -from_hole;
    return std::min(inside(plate), hole.DistanceTo(Vec3(p.x(), p.y(), 0)));
  }
};

std::unique_ptr<ElevationMap> MapOf(const Deck& deck, const std::vector<Vec2>& stands, bool update_each) {
  std::vector<Vec3> on_deck;
  for (const Vec2& stand : stands) on_deck.emplace_back(stand.x(), stand.y(), 0.0);
  return MapAfterSweeps(deck.world, on_deck,
                        {.seed = 21, .yaw_rad = 0.4, .depth_images = 1, .update_each = update_each});
}

/// Calls visit(p, margin) for the centres of all cells of the window.
template <typename Visit>
void ForCells(const ElevationMap& map, const Deck& deck, const Visit& visit) {
  const ElevationMap::Grid grid = map.Export();
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const Vec2 p = grid.origin + grid.cell_m * Vec2(c + 0.5, r + 0.5);
      visit(p, deck.Margin(p));
    }
  }
}

void ExpectHolesUntouched(const ElevationMap& map, const Deck& deck) {
  const core::RobotExtent robot;
  int traversable_off = 0, steppable_off = 0, circle_over = 0;
  ForCells(map, deck, [&](const Vec2& p, double margin) {
    if (margin < -1.5 * kCell) {
      traversable_off += map.Traversability(map.OnRobotsLevel(p, 0.0)) > 0;
      steppable_off += map.At(p.x(), p.y()).steppable;
    }
    if (margin < robot.footprint_radius_m - 0.5 * kCell)
      circle_over += map.CircleFree(map.OnRobotsLevel(p, 0.0));
  });
  EXPECT_EQ(traversable_off, 0);
  EXPECT_EQ(steppable_off, 0);
  EXPECT_EQ(circle_over, 0);
}

/// Of the deck within `range_m` of `stand` (rims aside): the share held to be solid at deck height.
double RecoveredShare(const ElevationMap& map, const Deck& deck, const Vec2& stand, double range_m) {
  double cells = 0, recovered = 0;
  ForCells(map, deck, [&](const Vec2& p, double margin) {
    if (margin < 0.1 || (p - stand).norm() > range_m) return;
    const auto ground = map.At(p.x(), p.y());
    cells += 1;
    recovered += ground.known && std::abs(ground.height_m) < 0.02 &&
                 map.Traversability(map.OnRobotsLevel(p, 0.0)) > 0.5;
  });
  return recovered / cells;
}

TEST(TerrainHoles, DeckEdgeAndStairwellAreNeverTraversableFromAnyStand) {
  const Deck deck(0.0);
  for (const Vec2& stand : {Vec2(0, 0), Vec2(-2.5, 2), Vec2(0.5, -2.2), Vec2(3.4, 0.1), Vec2(4.5, 3)}) {
    SCOPED_TRACE(stand.transpose());
    ExpectHolesUntouched(*MapOf(deck, {stand}, true), deck);
  }
}

TEST(TerrainHoles, StairwellStaysAHoleAfterAWalkRoundIt) {
  const Deck deck(0.0);
  const auto map = MapOf(deck, {{0, 0}, {0.6, 2.2}, {2.6, 2.2}, {3.6, 0}, {2.4, -2.1}, {0.6, -1.5}}, true);
  ExpectHolesUntouched(*map, deck);
  EXPECT_GT(RecoveredShare(*map, deck, {2.0, 0.0}, 3.0), 0.95);
}

TEST(TerrainHoles, PlanningPassesBetweenStairwellAndDeckEdge) {
  const Deck deck(0.0);
  const auto map = MapOf(deck, {{0, 0}, {0.6, 2.2}, {2.6, 2.5}}, true);
  for (double x = 0.5; x < 4.0; x += 0.1) EXPECT_TRUE(map->CircleFree({x, 2.6, 0.0})) << x;
}

TEST(TerrainHoles, GratingThatPassesHalfTheRaysIsSolidAtDeckHeight) {
  const Deck deck(0.5);
  for (const Vec2& stand : {Vec2(0, 0), Vec2(-0.5, 1.5)}) {
    const auto map = MapOf(deck, {stand}, true);
    EXPECT_GT(RecoveredShare(*map, deck, stand, 3.5), 0.9) << stand.transpose();
    ExpectHolesUntouched(*map, deck);
  }
}

TEST(TerrainHoles, GratingStaysSolidAndItsStairwellOpenAfterManySweeps) {
  const Deck deck(0.6);
  const auto map = MapOf(deck, {{0, 0}, {0.6, 2.2}, {2.6, 2.2}, {3.6, 0}}, false);
  ExpectHolesUntouched(*map, deck);
  EXPECT_GT(RecoveredShare(*map, deck, {2.0, 0.5}, 3.0), 0.9);
}

TEST(TerrainHoles, BlindGroundUnderTheRobotStaysSolidOnAGratingWhicheverBeamsItsBarsStop) {
  // At the rim of what the LiDAR sees about the robot's feet a few beams pass the bars, and by chance none of
  // their neighbours is stopped.
  const Deck deck(0.5);
  const Vec2 stand(-1.2, 0.5);
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    const auto map = MapAfterSweeps(deck.world, {{stand.x(), stand.y(), 0.0}},
                                    {.seed = seed, .depth_images = 0, .update_each = true});
    EXPECT_TRUE(map->CircleFree(Place(stand))) << seed;
  }
}

TEST(TerrainHoles, GroundAssumedAtTheStartYieldsToRaysThatGoThroughIt) {
  // The stairwell, to the robot's left where its LiDAR looks, reaches into the circle that is assumed solid.
  const Deck deck(0.0);
  ExpectHolesUntouched(*MapOf(deck, {{2.0, -1.95}}, true), deck);
}

}  // namespace
}  // namespace atlas::mapping
