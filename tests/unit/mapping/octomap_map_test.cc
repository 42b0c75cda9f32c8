#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include <filesystem>

#include "core/rng.h"
#include "tests/support/room_sweep.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using core::Vec3f;
using namespace tests;

octomap::point3d PointOf(const Vec3f& p) {
  return {p.x(), p.y(), p.z()};
}

octomap::OcTree TreeFor(const MapperParams& params) {
  octomap::OcTree tree(params.resolution_m);
  tree.setProbHit(params.hit_probability);
  tree.setProbMiss(params.miss_probability);
  tree.setClampingThresMin(params.clamp_min);
  tree.setClampingThresMax(params.clamp_max);
  return tree;
}

/// The probability that the view reports of the voxel about `center`, by a ray that ends within it.
double ViewedAt(const MapView& view, const Vec3& center) {
  std::vector<RaySample> samples;
  view.Trace(center, Vec3::UnitX(), {.max_range_m = 0.01}, &samples);
  return samples.size() == 1 ? static_cast<double>(samples[0].occupancy) : -1.0;
}

struct Agreement {
  size_t measured = 0, occupied = 0, differing = 0, cells = 0;
};
/// The view against a tree, every voxel of the region: probability, state and distance from it.
Agreement Compare(const MapView& view, const octomap::OcTree& tree) {
  Agreement n;
  const core::Box3& region = kSweptRegion;
  const double half = 0.5 * view.resolution_m();
  for (double x = region.min.x() + half; x < region.max.x(); x += 2.0 * half) {
    for (double y = region.min.y() + half; y < region.max.y(); y += 2.0 * half) {
      for (double z = region.min.z() + half; z < region.max.z(); z += 2.0 * half) {
        const auto* node = tree.search(x, y, z);
        const double p = node == nullptr ? 0.5 : node->getOccupancy();
        const CellState state = p > 0.8   ? CellState::kOccupied
                                : p < 0.2 ? CellState::kFree
                                          : CellState::kUnknown;
        ++n.cells;
        n.measured += node != nullptr;
        n.occupied += state == CellState::kOccupied;
        n.differing +=
            view.StateAt(Vec3(x, y, z)) != state || std::abs(ViewedAt(view, Vec3(x, y, z)) - p) > 1e-6;
      }
    }
  }
  return n;
}

TEST(OctomapMap, EqualsOneInsertionIntoTheLibrarysTreeARevolution) {
  const MapperParams params = OctomapParams();
  tests::PlacedSpins sweep = RoomSweep(6, 0.01, Vec3::Zero());  // the library knows one origin a cloud
  for (core::SpinEvent& event : sweep.spins) {
    for (core::ReturnKind& kind : event.scan.kind) {
      if (kind == core::ReturnKind::kVoid) kind = core::ReturnKind::kDropout;
    }
  }
  const auto mapper = MapOf(params, kSweptBox);
  octomap::OcTree tree = TreeFor(params);
  for (const core::SpinEvent& event : sweep.spins) {
    tests::Integrate(event, sweep.T_map_odom, mapper.get());
    UndistortedSpin spin;
    Undistort(event, sweep.T_map_odom, &spin);
    octomap::Pointcloud cloud;
    for (const MapRay& ray : spin.hits)
      cloud.push_back(PointOf(ray.origin_map + ray.range_m * ray.direction_map));
    tree.insertPointCloud(cloud, PointOf(spin.hits[0].origin_map), -1.0, false, true);
  }
  const Agreement n = Compare(*mapper->Snapshot(), tree);
  EXPECT_GT(n.measured, 60000u);
  EXPECT_GT(n.occupied, 2000u);
  EXPECT_EQ(n.differing, 0u) << "of " << n.cells;
}

/// As many library calls as there are sensor positions, rays that end in one voxel once, as above.
void InsertRayByRay(const UndistortedSpin& spin, double void_range_m, octomap::OcTree* tree) {
  octomap::KeySet passed, hit, ends;
  octomap::KeyRay keys;
  const auto clear = [&](const MapRay& ray, double range_m) {
    const Vec3f end = ray.origin_map + static_cast<float>(range_m) * ray.direction_map;
    const octomap::OcTreeKey key = tree->coordToKey(PointOf(end));
    if (!ends.insert(key).second) return;
    if (tree->computeRayKeys(PointOf(ray.origin_map), tree->keyToCoord(key), keys))
      passed.insert(keys.begin(), keys.end());
  };
  for (const MapRay& ray : spin.hits) {
    clear(ray, static_cast<double>(ray.range_m));
    hit.insert(tree->coordToKey(PointOf(ray.origin_map + ray.range_m * ray.direction_map)));
  }
  for (const MapRay& ray : spin.voids) clear(ray, void_range_m);
  for (const auto& key : passed) {
    if (hit.count(key) == 0) tree->updateNode(key, false);
  }
  for (const auto& key : hit) tree->updateNode(key, true);
}

TEST(OctomapMap, EqualsTheLibraryRayByRayWhereTheSensorMovesAndRaysAreVoid) {
  MapperParams params = OctomapParams();
  params.integrator.void_range_m = 1.2;  // ends inside the region
  const tests::PlacedSpins sweep = RoomSweep(6, 0.01);
  const auto mapper = MapOf(params, kSweptBox);
  tests::Integrate(sweep, mapper.get());
  octomap::OcTree tree = TreeFor(params);
  UndistortedSpin spin;
  for (const core::SpinEvent& event : sweep.spins) {
    Undistort(event, sweep.T_map_odom, &spin);
    ASSERT_GT(spin.voids.size(), 100u);
    InsertRayByRay(spin, params.integrator.void_range_m, &tree);
  }
  const Agreement n = Compare(*mapper->Snapshot(), tree);
  EXPECT_GT(n.measured, 60000u);
  EXPECT_EQ(n.differing, 0u) << "of " << n.cells;
}

/// How two maps of the same rays compare where rays are laid through other points of the voxels that they end
/// in: voxels that rays graze differ by a miss or two.
struct Overlap {
  double measured = 0, measured_in_one = 0;
  double surface = 0, surface_in_one = 0;   ///< rather occupied than not
  double evidence = 0, evidence_apart = 0;  ///< log-odds, summed over voxels

  void Add(double p, double q) {
    measured += p != 0.5 || q != 0.5;
    measured_in_one += (p != 0.5) != (q != 0.5);
    surface += p > 0.5 || q > 0.5;
    surface_in_one += (p > 0.5) != (q > 0.5);
    evidence += std::log(p / (1.0 - p));
    evidence_apart += std::log(p / (1.0 - p)) - std::log(q / (1.0 - q));
  }
};
template <typename Other>
Overlap Overlay(const MapView& view, const Other& other, const core::Box3& region = kSweptRegion) {
  Overlap n;
  for (double x = region.min.x() + 0.025; x < region.max.x(); x += 0.05) {
    for (double y = region.min.y() + 0.025; y < region.max.y(); y += 0.05) {
      for (double z = region.min.z() + 0.025; z < region.max.z(); z += 0.05) {
        n.Add(ViewedAt(view, Vec3(x, y, z)), other(Vec3(x, y, z)));
      }
    }
  }
  return n;
}

TEST(OctomapMap, RaysCutAtTheRegionClearWhatWholeRaysClear) {
  MapperParams params = OctomapParams();
  params.integrator.void_range_m = 9.0;
  const tests::PlacedSpins sweep = RoomSweep(6, 0.01);
  const core::Box3 inner{Vec3(-1.0, -1.2, 0.3), Vec3(1.3, 1.1, 1.4)};  // every ray leaves it
  const auto mapper = MapOf(params, inner);
  tests::Integrate(sweep, mapper.get());
  octomap::OcTree tree = TreeFor(params);
  UndistortedSpin spin;
  for (const core::SpinEvent& event : sweep.spins) {
    Undistort(event, sweep.T_map_odom, &spin);
    InsertRayByRay(spin, params.integrator.void_range_m, &tree);
  }
  const Overlap n = Overlay(
      *mapper->Snapshot(),
      [&](const Vec3& p) {
        const auto* node = tree.search(p.x(), p.y(), p.z());
        return node == nullptr ? 0.5 : node->getOccupancy();
      },
      RegionOf(params, inner));
  EXPECT_GT(n.measured, 20000.0);
  EXPECT_LT(n.measured_in_one, 0.5 * n.measured);
  EXPECT_EQ(n.surface, 0.0);
  EXPECT_LT(std::abs(n.evidence_apart), 0.25 * std::abs(n.evidence));
}

TEST(OctomapMap, SavesTheTreeItself) {
  const MapperParams params = OctomapParams();
  const tests::PlacedSpins sweep = RoomSweep(6, 0.01);
  const auto mapper = MapOf(params, kSweptBox);
  tests::Integrate(sweep, mapper.get());
  const auto dir = std::filesystem::temp_directory_path() / ("atlas_bt_" + std::to_string(::getpid()));
  std::filesystem::create_directories(dir);
  ASSERT_EQ(mapper->Save(dir), "map.bt");
  octomap::OcTree saved(0.1);
  ASSERT_TRUE(saved.readBinary((dir / "map.bt").string()));
  std::filesystem::remove_all(dir);
  const core::Box3 region = RegionOf(params, kSweptBox);
  size_t known = 0;
  for (double x = region.min.x() + 0.025; x < region.max.x(); x += 0.05) {
    for (double y = region.min.y() + 0.025; y < region.max.y(); y += 0.05) {
      for (double z = region.min.z() + 0.025; z < region.max.z(); z += 0.05) {
        const double p = ViewedAt(*mapper->Snapshot(), Vec3(x, y, z));
        const auto* node = saved.search(x, y, z);
        ASSERT_EQ(node != nullptr, p != 0.5) << x << " " << y << " " << z;
        if (node == nullptr) continue;
        ++known;
        ASSERT_EQ(saved.isNodeOccupied(node), p > 0.5);
      }
    }
  }
  EXPECT_GT(known, 50000u);
}

TEST(DenseGridMap, AgreesWithTheLibrarysTreeButForRaysThatGrazeCorners) {
  const tests::PlacedSpins sweep = RoomSweep(6, 0.01);
  MapperParams params = OctomapParams();
  const auto tree = MapOf(params, kSweptBox);
  params.name = "dense_grid";
  const auto grid = MapOf(params, kSweptBox);
  tests::Integrate(sweep, tree.get());
  tests::Integrate(sweep, grid.get());
  const Overlap n = Overlay(*tree->Snapshot(), [&](const Vec3& p) { return ViewedAt(*grid->Snapshot(), p); });
  EXPECT_GT(n.measured, 60000.0);
  EXPECT_GT(n.surface, 2000.0);
  EXPECT_LT(n.measured_in_one, 0.5 * n.measured);
  EXPECT_LT(n.surface_in_one, 0.25 * n.surface);
  EXPECT_LT(std::abs(n.evidence_apart), 0.1 * std::abs(n.evidence));
}

TEST(OctomapMap, VoidRaysClearOnlyToTheTrustedRangeAndOnlyWhenAsked) {
  tests::PlacedSpins sweep = RoomSweep(6, 0.0, Vec3::Zero());
  for (core::SpinEvent& event : sweep.spins) {
    std::fill(event.scan.kind.begin(), event.scan.kind.end(), core::ReturnKind::kVoid);
    for (int row = 0; row < 16; ++row) {  // level
      for (int c = 0; c < 120; ++c) event.scan.direction_lidar[static_cast<size_t>(row * 120 + c)].z() = 0.0f;
    }
    for (Vec3f& d : event.scan.direction_lidar) d.normalize();
  }
  MapperParams params = OctomapParams();
  params.integrator.void_range_m = 1.0;
  const auto clearing = MapOf(params, kSweptBox);
  tests::Integrate(sweep, clearing.get());
  const Vec3 sensor = sweep.T_map_odom * Vec3(0.3, -0.2, 0.92);
  const Vec3 forward = sweep.T_map_odom.linear() * Vec3::UnitX();
  EXPECT_EQ(clearing->Snapshot()->StateAt(sensor + 0.5 * forward), CellState::kFree);
  EXPECT_EQ(clearing->Snapshot()->StateAt(sensor + 1.1 * forward), CellState::kUnknown);
  params.integrator.void_rays = "ignore";
  const auto ignoring = MapOf(params, kSweptBox);
  tests::Integrate(sweep, ignoring.get());
  EXPECT_EQ(ignoring->Snapshot()->StateAt(sensor + 0.5 * forward), CellState::kUnknown);
}

TEST(OctomapMap, TraceListsTheVoxelsThatSamplingFinds) {
  const auto mapper = MapOf(OctomapParams(), kSweptBox);
  tests::Integrate(RoomSweep(12, 0.0, Vec3(0.05, 0.02, 0.0)), mapper.get());
  const std::shared_ptr<const MapView> snapshot = mapper->Snapshot();
  const MapView& view = *snapshot;
  core::Rng rng(5);
  std::vector<RaySample> samples;
  int ended_occupied = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Vec3 origin(rng.Uniform(-1.5, 1.5), rng.Uniform(-1.5, 1.5), rng.Uniform(0.3, 2.0));
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    const RayEnd end = view.Trace(origin, direction, {.box_map = kSweptRegion}, &samples);
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

}  // namespace
}  // namespace atlas::mapping
