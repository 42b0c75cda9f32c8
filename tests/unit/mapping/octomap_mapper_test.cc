#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <filesystem>

#include "core/errors.h"
#include "core/rng.h"
#include "mapping/mapper.h"
#include "mapping/undistort.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using core::Vec3f;

/// Spins in a 4 x 4 x 2.4 m room from the inside: distance to the walls in closed form, every tenth ray void.
core::Sweep RoomSweep(int spins, double noise, const Vec3& velocity = Vec3(0.5, 0.2, 0.0)) {
  core::Sweep sweep;
  core::Rng rng(3);
  const core::Box3 room{Vec3(-2, -2, 0), Vec3(2, 2, 2.4)};
  for (int s = 0; s < spins; ++s) {
    core::SpinEvent event;
    core::LidarScan& scan = event.scan;
    scan.rows = 16;
    scan.columns = 120;
    scan.stamp_s = 0.1 * s;
    const Vec3 start(0.3, -0.2, 0.92);
    for (double t = 0.0; t <= 0.1001; t += 0.01) {
      event.T_odom_lidar.Add(scan.stamp_s + t,
                             core::PoseFromXyzYaw(start + (scan.stamp_s + t) * velocity, 0.0));
    }
    for (int row = 0; row < scan.rows; ++row) {
      for (int column = 0; column < scan.columns; ++column) {
        const double azimuth = -2.0 * core::kPi * column / scan.columns,
                     elevation = core::Radians(-40 + 5 * row);
        const double time = 0.1 * column / scan.columns;
        const Vec3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
        const Vec3 origin = start + (scan.stamp_s + time) * velocity;
        const double range = room.Clip(origin, direction)->second + noise * rng.Normal();
        const bool is_void = row == 15;
        scan.direction_lidar.push_back(direction.cast<float>());
        scan.time_s.push_back(static_cast<float>(time));
        scan.range_m.push_back(is_void ? 0.0f : static_cast<float>(range));
        scan.kind.push_back(is_void ? core::ReturnKind::kVoid : core::ReturnKind::kHit);
      }
    }
    sweep.spins.push_back(std::move(event));
  }
  sweep.T_map_odom = core::PoseFromXyzYaw(Vec3(0.1, 0.05, 0.0), 0.1);
  return sweep;
}

MapperParams OctomapParams() {
  MapperParams params;
  params.name = "octomap";
  return params;
}

const core::Box3 kBox{Vec3(-2.3, -2.3, -0.2), Vec3(2.3, 2.3, 2.6)};

/// The library's own way: computeUpdate over each spin's cloud, ray by ray, then the same for void rays.
void InsertWithLibrary(const core::Sweep& sweep, const MapperParams& params, octomap::OcTree* tree) {
  UndistortedSpin spin;
  for (const core::SpinEvent& event : sweep.spins) {
    Undistort(event, sweep.T_map_odom, &spin);
    octomap::KeySet free_cells, hit_cells;
    octomap::KeyRay ray_keys;
    const auto add = [&](const MapRay& ray, double range, bool hit) {
      const Vec3 o = ray.origin_map.cast<double>(), e = o + range * ray.direction_map.cast<double>();
      const octomap::point3d origin(o.x(), o.y(), o.z()), end(e.x(), e.y(), e.z());
      if (tree->computeRayKeys(origin, end, ray_keys)) free_cells.insert(ray_keys.begin(), ray_keys.end());
      if (hit) hit_cells.insert(tree->coordToKey(end));
    };
    for (const MapRay& ray : spin.hits) add(ray, ray.range_m, true);
    for (const MapRay& ray : spin.voids) add(ray, params.void_range_m, false);
    for (const auto& key : free_cells) {
      if (hit_cells.count(key) == 0) tree->updateNode(key, false);
    }
    for (const auto& key : hit_cells) tree->updateNode(key, true);
  }
}

TEST(OctomapMapper, AgreesWithTheLibraryInsertedSpinBySpin) {
  MapperParams params = OctomapParams();
  params.void_range_m = 3.0;
  const core::Sweep sweep = RoomSweep(6, 0.01);
  const auto mapper = MakeMapper(params, kBox);
  mapper->Integrate(sweep);
  octomap::OcTree tree(params.resolution_m);
  tree.setProbHit(params.hit_probability);
  tree.setProbMiss(params.miss_probability);
  tree.setClampingThresMin(params.clamp_min);
  tree.setClampingThresMax(params.clamp_max);
  InsertWithLibrary(sweep, params, &tree);
  size_t cells = 0, differing = 0, known = 0;
  const core::Box3& region = mapper->view().region();
  for (double x = region.min.x() + 0.025; x < region.max.x(); x += 0.05) {
    for (double y = region.min.y() + 0.025; y < region.max.y(); y += 0.05) {
      for (double z = region.min.z() + 0.025; z < region.max.z(); z += 0.05) {
        const auto* node = tree.search(x, y, z);
        const double p = node == nullptr ? 0.5 : node->getOccupancy();
        const CellState expected = p > kOccupiedProbability ? CellState::kOccupied
                                   : p < kFreeProbability   ? CellState::kFree
                                                            : CellState::kUnknown;
        ++cells;
        known += expected != CellState::kUnknown;
        differing += mapper->view().StateAt(Vec3(x, y, z)) != expected;
      }
    }
  }
  EXPECT_GT(known, 50000u);
  // The library keeps the last voxel of a ray out of its free set and rounds in float; a few rays graze
  // corners.
  EXPECT_LT(static_cast<double>(differing), 0.004 * static_cast<double>(cells));
}

TEST(OctomapMapper, VoidRaysClearOnlyToTheTrustedRangeAndOnlyWhenAsked) {
  core::Sweep sweep = RoomSweep(6, 0.0, Vec3::Zero());
  for (core::SpinEvent& event : sweep.spins) {
    std::fill(event.scan.kind.begin(), event.scan.kind.end(), core::ReturnKind::kVoid);
    for (int row = 0; row < 16; ++row) {  // level
      for (int c = 0; c < 120; ++c) event.scan.direction_lidar[static_cast<size_t>(row * 120 + c)].z() = 0.0f;
    }
    for (Vec3f& d : event.scan.direction_lidar) d.normalize();
  }
  MapperParams params = OctomapParams();
  params.void_range_m = 1.0;
  const auto clearing = MakeMapper(params, kBox);
  clearing->Integrate(sweep);
  const Vec3 sensor = sweep.T_map_odom * Vec3(0.3, -0.2, 0.92);
  const Vec3 forward = sweep.T_map_odom.linear() * Vec3::UnitX();
  EXPECT_EQ(clearing->view().StateAt(sensor + 0.5 * forward), CellState::kFree);
  EXPECT_EQ(clearing->view().StateAt(sensor + 1.1 * forward), CellState::kUnknown);
  params.void_rays = "ignore";
  const auto ignoring = MakeMapper(params, kBox);
  ignoring->Integrate(sweep);
  EXPECT_EQ(ignoring->view().StateAt(sensor + 0.5 * forward), CellState::kUnknown);
}

TEST(OctomapMapper, CloudIsUndistortedOnTheTrueWalls) {
  const core::Sweep sweep = RoomSweep(5, 0.0);
  const core::PointCloud cloud =
      AccumulateSweep(sweep, core::Box3{Vec3(-9, -9, -9), Vec3(9, 9, 9)}, 20.0, 0.015);
  ASSERT_GT(cloud.points.size(), 3000u);
  const Pose T_room_map = sweep.T_map_odom.inverse();
  for (const Vec3f& p : cloud.points) {
    const Vec3 q = T_room_map * p.cast<double>();
    const double wall = std::min({2.0 - std::abs(q.x()), 2.0 - std::abs(q.y()), q.z(), 2.4 - q.z()});
    ASSERT_LT(std::abs(wall), 1e-3) << q.transpose();
  }
}

TEST(OctomapMapper, TraceListsTheVoxelsThatSamplingFinds) {
  const auto mapper = MakeMapper(OctomapParams(), kBox);
  mapper->Integrate(RoomSweep(12, 0.0, Vec3(0.05, 0.02, 0.0)));
  const OccupancyView& view = mapper->view();
  core::Rng rng(5);
  std::vector<RaySample> samples;
  int ended_occupied = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 origin(rng.Uniform(-1.5, 1.5), rng.Uniform(-1.5, 1.5), rng.Uniform(0.3, 2.0));
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const RayEnd end = view.Trace(origin, direction, 20.0, &samples);
    double t = 0.0;
    for (size_t i = 0; i < samples.size(); ++i) {
      const double length = static_cast<double>(samples[i].length_m);
      if (length > 1e-3) {
        const Vec3 middle = origin + (t + 0.5 * length) * direction;
        const CellState state = view.StateAt(middle);
        const bool occupied = static_cast<double>(samples[i].occupancy) > kOccupiedProbability;
        EXPECT_EQ(state == CellState::kOccupied, occupied);
        EXPECT_EQ(occupied, i + 1 == samples.size() && end == RayEnd::kOccupied);
      }
      t += length;
    }
    ended_occupied += end == RayEnd::kOccupied;
  }
  EXPECT_GT(ended_occupied, 30);
}

TEST(OctomapMapper, DistanceToOccupiedMatchesBruteForce) {
  const auto mapper = MakeMapper(OctomapParams(), kBox);
  mapper->Integrate(RoomSweep(3, 0.0));
  const auto centers = mapper->view().OccupiedCenters();
  ASSERT_FALSE(centers.empty());
  core::Rng rng(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 p(rng.Uniform(-4, 4), rng.Uniform(-4, 4), rng.Uniform(-1, 3));
    double best = 1.5;
    for (const Vec3f& c : centers) best = std::min(best, (c.cast<double>() - p).norm());
    EXPECT_NEAR(mapper->view().DistanceToOccupied(p, 1.5), best, 1e-4);
  }
}

TEST(OctomapMapper, SavedTreeReadsBackWithTheSameOccupiedCells) {
  const auto mapper = MakeMapper(OctomapParams(), kBox);
  mapper->Integrate(RoomSweep(6, 0.0));
  const auto dir = std::filesystem::temp_directory_path() / ("atlas_bt_" + std::to_string(::getpid()));
  const std::string file = mapper->Save(dir);
  octomap::OcTree tree(0.1);
  ASSERT_TRUE(tree.readBinary((dir / file).string()));
  for (const Vec3f& c : mapper->view().OccupiedCenters()) {
    const auto* node =
        tree.search(static_cast<double>(c.x()), static_cast<double>(c.y()), static_cast<double>(c.z()));
    ASSERT_NE(node, nullptr);
    EXPECT_TRUE(tree.isNodeOccupied(node));
  }
  std::filesystem::remove_all(dir);
}

TEST(Mapper, RegionTooLargeForTheResolutionIsRefused) {
  MapperParams params = OctomapParams();
  params.resolution_m = 0.02;
  EXPECT_THROW(MakeMapper(params, core::Box3{Vec3(-200, -200, 0), Vec3(200, 200, 20)}), core::InputError);
  params.name = "octomop";
  EXPECT_THROW(MakeMapper(params, kBox), core::InputError);
}

}  // namespace
}  // namespace atlas::mapping
