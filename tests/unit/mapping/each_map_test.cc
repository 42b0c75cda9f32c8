#include <gtest/gtest.h>

#include <thread>

#include "core/errors.h"
#include "core/rng.h"
#include "mapping/grid/occupied_index.h"
#include "tests/support/room_sweep.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using core::Vec3f;
using namespace tests;

TEST(ScanCloud, IsUndistortedOnTheTrueWalls) {
  const tests::PlacedSpins sweep = RoomSweep(5, 0.0);
  const ReturnCloud cloud = tests::CloudOf(sweep, {Vec3(-9, -9, -9), Vec3(9, 9, 9)}, 20.0, 0.015);
  ASSERT_GT(cloud.points.size(), 3000u);
  const Pose T_room_map = sweep.T_map_odom.inverse();
  for (const Vec3f& p : cloud.points) {
    const Vec3 q = T_room_map * p.cast<double>();
    const double wall = std::min({2.0 - std::abs(q.x()), 2.0 - std::abs(q.y()), q.z(), 2.4 - q.z()});
    ASSERT_LT(std::abs(wall), 1e-3) << q.transpose();
  }
}

TEST(OccupiedIndex, DistanceMatchesBruteForce) {
  const auto mapper = MapOf(OctomapParams(), kSweptBox);
  tests::Integrate(RoomSweep(3, 0.0), mapper.get());
  const auto centers = OccupiedCenters(*mapper->Snapshot(), kSweptRegion);
  ASSERT_FALSE(centers.empty());
  OccupiedIndex index(kSweptRegion);
  index.Build(centers);
  core::Rng rng(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 p(rng.Uniform(-4, 4), rng.Uniform(-4, 4), rng.Uniform(-1, 3));
    double best = 1.5;
    for (const Vec3f& c : centers) best = std::min(best, (c.cast<double>() - p).norm());
    EXPECT_NEAR(index.DistanceTo(p, 1.5), best, 1e-4);
  }
}

/// Every mapper of the catalogue.
class EachMap : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<Map> Make() const {
    MapperParams params;
    params.name = GetParam();
    return MapOf(params, kSweptBox);
  }
};

TEST_P(EachMap, ViewIsWholeWhicheverThreadAsksFirst) {
  const tests::PlacedSpins sweep = RoomSweep(4, 0.01);
  const auto quiet = Make(), busy = Make();
  for (const core::SpinEvent& event : sweep.spins) {
    tests::Integrate(event, sweep.T_map_odom, quiet.get());
    tests::Integrate(event, sweep.T_map_odom, busy.get());
    size_t bytes = 0, known = 0;
    std::vector<Vec3f> occupied;
    std::thread scorer([&] {
      bytes = busy->Bytes();
      known = busy->Snapshot()->StateAt(Vec3(0.3, -0.2, 0.6)) != CellState::kUnknown;
    });
    occupied = OccupiedCenters(*busy->Snapshot(), kSweptRegion);
    scorer.join();
    EXPECT_TRUE(occupied == OccupiedCenters(*quiet->Snapshot(), kSweptRegion));
    EXPECT_EQ(bytes, quiet->Bytes());
    EXPECT_EQ(known, quiet->Snapshot()->StateAt(Vec3(0.3, -0.2, 0.6)) != CellState::kUnknown);
  }
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EachMap, ::testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const CatalogEntry& entry : Catalog()) names.push_back(entry.name);
                           return names;
                         }()),
                         [](const auto& info) { return info.param; });

TEST_P(EachMap, ASnapshotStaysAsItWasWhileTheMapGoesOn) {
  const tests::PlacedSpins sweep = RoomSweep(4, 0.01);
  const auto map = Make();
  tests::Integrate(sweep.spins[0], sweep.T_map_odom, map.get());
  const std::shared_ptr<const MapView> before = map->Snapshot();
  const std::vector<Vec3f> occupied = OccupiedCenters(*before, kSweptRegion);
  tests::PlacedSpins rest = sweep;
  rest.T_map_odom = core::PoseFromXyzYaw({0.4, 0.3, 0.0}, 0.3);  // walls elsewhere
  std::thread reader([&] {
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(OccupiedCenters(*before, kSweptRegion) == occupied);
  });
  tests::Integrate(rest, map.get());
  reader.join();
  EXPECT_TRUE(OccupiedCenters(*before, kSweptRegion) == occupied);
  EXPECT_GT(OccupiedCenters(*map->Snapshot(), kSweptRegion).size(), occupied.size());
}

TEST_P(EachMap, NothingIsKeptOutsideTheBox) {
  const tests::PlacedSpins sweep = RoomSweep(4, 0.01);
  MapperParams params;
  params.name = GetParam();
  const core::Box3 half{Vec3(-2.3, -2.3, -0.2), Vec3(0.0, 2.3, 2.6)};
  const auto map = MakeMap(params, {.keep_map = RegionOf(params, half)});
  tests::Integrate(sweep, map.get());
  const std::shared_ptr<const MapView> view = map->Snapshot();
  size_t known = 0;
  for (double x = -2.0; x < 2.0; x += 0.1) {
    const bool is_known = view->StateAt(Vec3(x, 0.3, 1.0)) != CellState::kUnknown;
    known += is_known;
    EXPECT_TRUE(x < 0.25 || !is_known) << x;
  }
  EXPECT_GT(known, 3u);
}

/// Twenty voxels deep, so that the first would be worth 39.
TEST_P(EachMap, WhatLiesBehindAHitIsMarkedByOneRuleUpTo31) {
  MapperParams params;
  params.name = GetParam();
  params.behind_surface_m = 1.0;
  const auto map =
      MakeMap(params, {.lidar = {}, .keep_map = RegionOf(params, kSweptBox), .behind_surface = true});
  tests::Integrate(RoomSweep(4, 0.0), map.get());
  std::vector<RaySample> samples;
  float most = 0.0f;
  const std::shared_ptr<const MapView> view = map->Snapshot();
  for (double z = 0.5; z < 1.5; z += 0.05) {  // beams lie 17 cm apart there
    view->Trace(Vec3(4.0, 0.2, z), -Vec3::UnitX(), {.box_map = kSweptRegion}, &samples);
    for (const RaySample& s : samples) most = std::max(most, s.behind_surface);
  }
  EXPECT_EQ(most, 31.0f);
}

TEST(Map, ADenseGridTooLargeForItsResolutionIsRefused) {
  MapperParams params = OctomapParams();
  params.name = "dense_grid";
  params.resolution_m = 0.02;
  EXPECT_THROW(MapOf(params, core::Box3{Vec3(-200, -200, 0), Vec3(200, 200, 20)}), core::InputError);
  EXPECT_THROW(MakeMap(params, {}), core::InputError) << "no box to keep";
  params.name = "octomop";
  EXPECT_THROW(MapOf(params, kSweptBox), core::InputError);
}

}  // namespace
}  // namespace atlas::mapping
