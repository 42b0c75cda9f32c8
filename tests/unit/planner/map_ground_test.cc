// Ways on a map that is given voxel by voxel.
#include "planner/views/map_ground.h"

#include <gtest/gtest.h>

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;
using mapping::CellState;

/// A hall of 12 x 8 m with a wall along x = 6 that has one doorway, `door_m` wide about y = 6.
class Hall final : public mapping::MapView {
 public:
  explicit Hall(double door_m) : door_m_(door_m) {}
  double resolution_m() const override { return 0.1; }
  CellState StateAt(const Vec3& p) const override {
    if (p.x() < 0 || p.y() < 0 || p.x() > 12 || p.y() > 8 || p.z() < -1.5 || p.z() > 3)
      return CellState::kUnknown;
    const bool patch = p.y() > 5 && p.y() < 6;
    if (patch && p.x() > 1 && p.x() < 2 && p.z() < 0.5) return CellState::kUnknown;  // unseen below
    if (patch && p.x() > 3 && p.x() < 4) return CellState::kUnknown;                 // unseen
    if (p.z() < 0.0 && patch && p.x() > 10 && p.x() < 11) return CellState::kFree;   // a pit
    if (p.z() < 0.0) return CellState::kOccupied;
    const bool wall = std::abs(p.x() - 6.0) < 0.15 && std::abs(p.y() - 6.0) > 0.5 * door_m_;
    return wall ? CellState::kOccupied : CellState::kFree;
  }
  mapping::RayEnd Trace(const Vec3&, const Vec3&, const mapping::TraceLimits&,
                        std::vector<mapping::RaySample>*) const override {
    return mapping::RayEnd::kVoid;
  }
  void ForEachOccupied(const core::Box3&, const VisitCenter&) const override {}

 private:
  double door_m_;
};

const core::Box3 kHall{Vec3(0, 0, -0.2), Vec3(12, 8, 3)};

TEST(MapGround, StandsWhereTheBodyIsClear) {
  const Hall hall(1.2);
  const MapGround ground(hall, {.radius_m = 0.4});
  EXPECT_TRUE(ground.CanStand({3, 4, 0.1}));
  EXPECT_FALSE(ground.CanStand({5.6, 2, 0.1}));  // the wall is 0.25 m off
  EXPECT_FALSE(ground.CanStand({0.3, 4, 0.1}));  // nothing is known beyond the hall
  EXPECT_TRUE(ground.CanStand({6, 6, 0.1}));     // in the doorway
  EXPECT_NEAR(ground.ColumnAt({3, 4, 0.1}).value(), 0.0, 0.11);
}

TEST(MapGround, GroundGoesOnWhereNoneWasSeenButNotOverAPit) {
  const Hall hall(1.2);
  const MapGround ground(hall, {.radius_m = 0.3});
  EXPECT_TRUE(ground.CanStand({1.5, 5.5, 0.1}));
  EXPECT_FALSE(ground.CanStand({3.5, 5.5, 0.1}));
  EXPECT_FALSE(ground.CanStand({10.5, 5.5, 0.1}));
  EXPECT_FALSE(ground.CanStand({10.5, 4.85, 0.1}));  // its rim
}

TEST(MapGround, WaysLeadThroughTheDoorway) {
  const Hall hall(1.2);
  const MapGround ground(hall, {.radius_m = 0.4});
  const auto way = PlanOnMap(ground, kHall, {2, 2, 0.3}, {10, 2, 0.3}, 3000, core::Rng(1));
  ASSERT_TRUE(way.has_value());
  for (size_t i = 1; i < way->points.size(); ++i) {
    const Vec3 a = way->points[i - 1], b = way->points[i];
    if ((a.x() - 6.0) * (b.x() - 6.0) > 0.0) continue;
    const double y = a.y() + (b.y() - a.y()) * (6.0 - a.x()) / (b.x() - a.x());
    EXPECT_NEAR(y, 6.0, 0.3);
  }
  // Straight lines from end to end over the nearer side of the doorway (5.8, 6): 2 x 5.46 m; the body keeps
  // off.
  EXPECT_GT(way->length_m, 10.9);
  EXPECT_LT(way->length_m, 12.6);
}

TEST(MapGround, NoWayThroughADoorwayNarrowerThanTheBody) {
  const Hall hall(0.7);
  const MapGround ground(hall, {.radius_m = 0.4});
  EXPECT_FALSE(PlanOnMap(ground, kHall, {2, 2, 0.3}, {10, 2, 0.3}, 1500, core::Rng(1)).has_value());
}

TEST(MapGround, PlansTheSameWayAgain) {
  const Hall hall(1.2);
  const MapGround ground(hall, {.radius_m = 0.4});
  const auto first = PlanOnMap(ground, kHall, {2, 2, 0.3}, {10, 2, 0.3}, 800, core::Rng(4));
  const auto second = PlanOnMap(ground, kHall, {2, 2, 0.3}, {10, 2, 0.3}, 800, core::Rng(4));
  ASSERT_EQ(first.has_value(), second.has_value());
  if (!first) return;
  ASSERT_EQ(first->points.size(), second->points.size());
  for (size_t i = 0; i < first->points.size(); ++i) EXPECT_EQ(first->points[i], second->points[i]);
}

}  // namespace
}  // namespace atlas::planner
