#include "mapping/grid/dense_grid.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/rng.h"
#include "tests/support/voxel_world.h"

namespace atlas::mapping {
namespace {

using core::Vec3;

constexpr double kRes = 0.05;
const core::Box3 kRegion{Vec3(-0.65, -0.5, -0.2), Vec3(1.85, 1.5, 1.35)};  // not whole blocks

/// The same map twice: large free stretches of one or more values, unknown space, and single voxels.
struct Twins {
  explicit Twins(uint64_t seed) : grid(kRegion, kRes), world(grid.region(), kRes) {
    core::Rng rng(seed);
    const float levels[] = {-2.0f, -1.8f, 1.7f, 3.5f, 0.3f, -0.6f};
    const auto fill = [&](double half, float log_odds) {
      const Vec3 size = kRegion.Size();
      const double x = rng.Uniform(), y = rng.Uniform();
      const Vec3 center = kRegion.min + size.cwiseProduct(Vec3(x, y, rng.Uniform()));
      const core::Box3 box{center.array() - half, center.array() + half};
      for (size_t i = 0; i < grid.frame().count(); ++i) {
        const Vec3 p = grid.frame().CenterOf(i);
        if (!box.Contains(p)) continue;
        grid.SetLogOdds(i, log_odds);
        world.Set(p, static_cast<float>(1.0 / (1.0 + std::exp(-log_odds))));
      }
    };
    for (int i = 0; i < 6; ++i) fill(0.7, levels[rng.UniformInt(2)]);
    for (int i = 0; i < 60; ++i) fill(0.02 + 0.1 * rng.Uniform(), levels[rng.UniformInt(6)]);
    grid.FinishUpdate();
  }
  DenseGrid grid;
  tests::VoxelWorld world;
};

struct Stretch {
  float occupancy;
  double length_m = 0.0;
  int voxels = 0;
};
/// Samples of one free occupancy in a row as one; voxels that the ray only touches left out.
std::vector<Stretch> Stretches(const std::vector<RaySample>& samples) {
  std::vector<Stretch> stretches;
  for (const RaySample& s : samples) {
    if (s.length_m < 1e-6f) continue;
    const bool joins = !stretches.empty() && stretches.back().occupancy < 0.2f &&
                       std::abs(stretches.back().occupancy - s.occupancy) < 1e-4f;
    if (!joins) stretches.push_back({s.occupancy});
    stretches.back().length_m += static_cast<double>(s.length_m);
    stretches.back().voxels += static_cast<int>(s.voxels);
  }
  return stretches;
}

TEST(DenseGrid, TraceMeetsTheVoxelsThatPlaneCrossingsMeetFreeOnesInRuns) {
  core::Rng rng(21);
  size_t long_runs = 0, ends = 0;
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    const Twins twins(seed);
    for (int trial = 0; trial < 300; ++trial) {
      const double x = rng.Uniform(-2.0, 3.0), y = rng.Uniform(-2.0, 3.0);
      const Vec3 origin(x, y, rng.Uniform(-1.0, 2.0));
      Vec3 target = kRegion.min + 0.5 * kRegion.Size() + 0.5 * Vec3(rng.Normal(), rng.Normal(), rng.Normal());
      if (trial % 5 == 0) target[rng.UniformInt(3)] = 0.123;
      Vec3 direction = (target - origin).normalized();
      if (trial % 7 == 0) direction = Vec3::Unit(rng.UniformInt(3));
      const double range_m = rng.Uniform(1.0, 8.0);
      std::vector<RaySample> runs, voxels;
      const RayEnd end = twins.grid.Trace(origin, direction, {.max_range_m = range_m}, &runs);
      ASSERT_EQ(end, twins.world.Trace(origin, direction, {.max_range_m = range_m}, &voxels));
      const auto expected = Stretches(voxels), found = Stretches(runs);
      ASSERT_EQ(found.size(), expected.size()) << seed << " " << trial;
      for (size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i].occupancy, expected[i].occupancy, 1e-5);
        EXPECT_NEAR(found[i].length_m, expected[i].length_m, 1e-5);
        EXPECT_NEAR(found[i].voxels, expected[i].voxels, 1) << "but for a voxel touched at a corner";
        long_runs += found[i].voxels > 16;
      }
      ends += end == RayEnd::kOccupied;
    }
  }
  EXPECT_GT(long_runs, 300u);
  EXPECT_GT(ends, 150u);
}

TEST(DenseGrid, RunsAreOfFreeVoxelsOnly) {
  const Twins twins(3);
  std::vector<RaySample> samples;
  core::Rng rng(22);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    twins.grid.Trace(Vec3(0.5, 0.5, 0.5), direction, {.max_range_m = 5.0}, &samples);
    for (const RaySample& s : samples) {
      EXPECT_TRUE(s.voxels == 1 || s.occupancy < static_cast<float>(kFreeProbability));
    }
  }
}

TEST(DenseGrid, OccupiedCentresAreThoseOfTheVoxelsAbove08) {
  const Twins twins(4);
  const std::vector<core::Vec3f> expected = OccupiedCenters(twins.world, kRegion.Inflated(1.0)),
                                 found = OccupiedCenters(twins.grid, kRegion.Inflated(1.0));
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_GT(found.size(), 100u);
  for (size_t i = 0; i < found.size(); ++i) EXPECT_LT((found[i] - expected[i]).norm(), 1e-4f);
}

}  // namespace
}  // namespace atlas::mapping
