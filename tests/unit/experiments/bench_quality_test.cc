// Which probes of a bench lie in voxels that a surface runs through, against samples of the surface.
#include <gtest/gtest.h>

#include <set>

#include "experiments/bench/map_quality.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

using core::Vec3;
using mapping::CellState;

TEST(MapQuality, VoxelsWithoutSurfaceHoldNoSampleOfIt) {
  const double kVoxel = 0.26;
  const BenchDataset dataset = RecordBenchDataset("rooms_small", 2, 2, [](double) {});
  QualityOptions options;
  options.resolution_m = kVoxel;
  QualityProbes probes(dataset, options);
  for (size_t scan = 0; scan < dataset.spins.size(); ++scan) probes.AddScan(scan);

  const auto cell_of = [kVoxel](const Vec3& p) {
    const Vec3 c = (p / kVoxel).array().floor();
    return std::array<int, 3>{static_cast<int>(c.x()), static_cast<int>(c.y()), static_cast<int>(c.z())};
  };
  std::set<std::array<int, 3>> surface;
  for (const auto& p : scenes::SampleGroundTruth(dataset.scene, 0.03).points) {
    surface.insert(cell_of(p.cast<double>()));
  }
  const auto state = [&](const Vec3& p) {
    const bool ground = cell_of(p)[2] == cell_of(Vec3(p.x(), p.y(), -1e-4))[2];
    return ground || surface.contains(cell_of(p)) ? CellState::kOccupied : CellState::kFree;
  };
  const MapQuality quality = probes.Judge(state);
  EXPECT_EQ(quality.free_on_rays_empty, 1.0);
  EXPECT_EQ(quality.free_between_30_empty, 1.0);
  EXPECT_LT(quality.free_on_rays, 0.99) << "many probes share their voxel with a wall";
  EXPECT_GT(quality.free_on_rays, 0.9);
  EXPECT_NEAR(quality.free_on_rays_exact, quality.free_on_rays, 0.01);
  EXPECT_NEAR(quality.free_between_30_exact, quality.free_between_30, 0.01);
  EXPECT_EQ(quality.occupied_near_hit, 1.0);
  EXPECT_EQ(probes.Judge([](const Vec3&) { return CellState::kUnknown; }).free_on_rays_empty, 0.0);
}

}  // namespace
}  // namespace atlas::experiments
