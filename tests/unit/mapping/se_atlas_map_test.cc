#include <gtest/gtest.h>

#include <filesystem>

#include "core/rng.h"
#include "mapping/backends/catalog.h"
#include "mapping/io/map_file.h"
#include "tests/support/placed_spins.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;

const core::Box3 kRoom{Vec3(-2.0, -2.0, 0.0), Vec3(2.0, 2.0, 2.4)};
const core::Box3 kRoomRegion = RegionOf(MapperParams{}, {Vec3(-2.3, -2.3, -0.2), Vec3(2.3, 2.3, 2.6)});

/// A VLP-16 that rolls from +40 to -40 degrees and back in a room: ranges in closed form, each ray from where
/// the sensor is at its own time.
tests::PlacedSpins RollingSweep(int spins) {
  const core::LidarModel lidar = core::FindLidarModel("vlp16");
  tests::PlacedSpins sweep;
  sweep.T_map_odom = core::PoseFromXyzYaw(Vec3(0.7, -0.4, 0.3), 0.6);
  core::Rng rng(3);
  const double period = 1.0 / lidar.spin_rate_hz, total = spins * period;
  const auto pose_at = [&](double t) {
    const double roll = core::Radians(40.0) * (1.0 - 4.0 * std::abs(t / total - 0.5)) * -1.0;
    return core::MakePose(core::RotationFromYawPitchRoll(0.3, 0.0, roll), Vec3(0.3, -0.2, 0.92));
  };
  for (int s = 0; s < spins; ++s) {
    core::SpinEvent event;
    core::LidarScan& scan = event.scan;
    scan.rows = lidar.rows();
    scan.columns = lidar.columns;
    scan.stamp_s = period * s;
    scan.min_range_m = static_cast<float>(lidar.min_range_m);
    scan.max_range_m = static_cast<float>(lidar.max_range_m);
    for (double t = 0.0; t <= period + 1e-4; t += 0.005) {
      event.T_odom_lidar.Add(scan.stamp_s + t, sweep.T_map_odom.inverse() * pose_at(scan.stamp_s + t));
    }
    for (int row = 0; row < scan.rows; ++row) {
      for (int column = 0; column < scan.columns; ++column) {
        const double time = period * column / scan.columns;
        const Vec3 direction = lidar.Direction(row, column);
        const core::Pose T = sweep.T_map_odom * event.T_odom_lidar.At(scan.stamp_s + time);
        const double range = kRoom.Clip(T.translation(), T.linear() * direction)->second;
        scan.direction_lidar.push_back(direction.cast<float>());
        scan.time_s.push_back(static_cast<float>(time));
        scan.range_m.push_back(static_cast<float>(range + 0.005 * rng.Normal()));
        scan.kind.push_back(core::ReturnKind::kHit);
      }
    }
    sweep.spins.push_back(std::move(event));
  }
  return sweep;
}

std::unique_ptr<Map> Make(const std::string& name) {
  MapperParams params;
  params.name = name;
  return MakeMap(params,
                 {.lidar = core::FindLidarModel("vlp16"), .keep_map = kRoomRegion, .behind_surface = true});
}

struct Counts {
  double free = 0, occupied = 0, freed_wall = 0, occupied_away = 0, free_outside = 0;
};
Counts CountStates(const MapView& view) {
  Counts n;
  const core::Box3& region = kRoomRegion;
  for (double x = region.min.x() + 0.025; x < region.max.x(); x += 0.05) {
    for (double y = region.min.y() + 0.025; y < region.max.y(); y += 0.05) {
      for (double z = region.min.z() + 0.025; z < region.max.z(); z += 0.05) {
        const CellState state = view.StateAt(Vec3(x, y, z));
        // Distance to the walls, negative outside.
        const double inside = std::min({2.0 - std::abs(x), 2.0 - std::abs(y), z, 2.4 - z});
        n.free += state == CellState::kFree;
        n.occupied += state == CellState::kOccupied;
        n.free_outside += state == CellState::kFree && inside < -0.026;
        n.occupied_away += state == CellState::kOccupied && std::abs(inside) > 0.13;
      }
    }
  }
  return n;
}

TEST(SeAtlasMap, RoomIsFreeInsideOccupiedOnItsWallsAndUnknownBeyond) {
  const tests::PlacedSpins sweep = RollingSweep(30);
  const auto atlas = Make("se_atlas"), octomap = Make("octomap");
  tests::Integrate(sweep, atlas.get());
  tests::Integrate(sweep, octomap.get());
  const Counts a = CountStates(*atlas->Snapshot()), o = CountStates(*octomap->Snapshot());
  EXPECT_GT(a.free, 0.97 * o.free);
  EXPECT_GT(a.occupied, 0.9 * o.occupied);
  EXPECT_LE(a.free_outside, 0.001 * a.free);
  EXPECT_LE(a.occupied_away, 0.01 * a.occupied);
  EXPECT_LT(atlas->Bytes(), octomap->Bytes());
}

TEST(SeAtlasMap, ViewIsTheSameWhenItIsReadAfterEverySpinOrOnce) {
  const tests::PlacedSpins sweep = RollingSweep(6);
  const auto once = Make("se_atlas"), often = Make("se_atlas");
  tests::Integrate(sweep, once.get());
  std::vector<std::shared_ptr<const MapView>> held;  // so that each revolution goes into a copy
  for (const core::SpinEvent& spin : sweep.spins) {
    tests::Integrate(spin, sweep.T_map_odom, often.get());
    held.push_back(often->Snapshot());
  }
  EXPECT_TRUE(OccupiedCenters(*once->Snapshot(), kRoomRegion) ==
              OccupiedCenters(*often->Snapshot(), kRoomRegion));
  core::Rng rng(5);
  std::vector<RaySample> a, b;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    once->Snapshot()->Trace(Vec3(0.1, 0.2, 1.0), direction, {.box_map = kRoomRegion}, &a);
    often->Snapshot()->Trace(Vec3(0.1, 0.2, 1.0), direction, {.box_map = kRoomRegion}, &b);
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].occupancy, b[i].occupancy);
      EXPECT_EQ(a[i].behind_surface, b[i].behind_surface);
    }
  }
}

TEST(SeAtlasMap, BehindSurfaceIsStoredInUnmeasuredVoxelsBehindWalls) {
  const auto atlas = Make("se_atlas");
  tests::Integrate(RollingSweep(6), atlas.get());
  std::vector<RaySample> samples;
  int marked = 0;
  // From outside through the wall: what lies behind it was never measured.
  for (double y = -1.0; y < 1.0; y += 0.1) {
    atlas->Snapshot()->Trace(Vec3(4.0, y, 1.0), -Vec3::UnitX(), {.box_map = kRoomRegion}, &samples);
    for (const RaySample& s : samples) {
      marked += s.behind_surface > 0.0f;
      EXPECT_TRUE(s.behind_surface == 0.0f || s.occupancy == 0.5f);
      EXPECT_LE(s.behind_surface, 11.0f) << "2 D - 1, D = 6 voxels";
    }
  }
  EXPECT_GT(marked, 10);
}

TEST(SeAtlasMap, SavedMapReadsBackWithTheSameOccupiedVoxels) {
  const auto atlas = Make("se_atlas");
  tests::Integrate(RollingSweep(6), atlas.get());
  const auto dir = std::filesystem::temp_directory_path() / ("atlas_map_" + std::to_string(::getpid()));
  std::filesystem::create_directories(dir);
  const std::string file = atlas->Save(dir);
  EXPECT_EQ(file, "map.atlas");
  const AnyOctree read = ReadMap(dir / file);
  const auto& tree = std::get<OccupancyOctree>(read);
  const auto centers = OccupiedCenters(*atlas->Snapshot(), kRoomRegion);
  ASSERT_GT(centers.size(), 1000u);
  for (const Vec3f& c : centers) {
    EXPECT_TRUE(OccupancyField::Occupied(tree.At(Vec3(c.cast<double>()))));
  }
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace atlas::mapping
