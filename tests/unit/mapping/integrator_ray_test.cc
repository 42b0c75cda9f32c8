// The ray integrator against a dense grid that is cast by sorting plane crossings.
#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "mapping/integrator/integrator.h"
#include "mapping/octree/rolling.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = OccupancyField;
using Voxel = std::tuple<int, int, int>;

constexpr double kResolution = 0.11;

Voxel VoxelOf(const Vec3& p) {
  return {static_cast<int>(std::floor(p.x() / kResolution)),
          static_cast<int>(std::floor(p.y() / kResolution)),
          static_cast<int>(std::floor(p.z() / kResolution))};
}

/// Voxels between two points, end excluded, by sorting where the segment meets the planes of the lattice.
std::set<Voxel> Crossed(const Vec3& a, const Vec3& b) {
  std::vector<double> cuts = {0.0, 1.0};
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = std::min(a[axis], b[axis]), hi = std::max(a[axis], b[axis]);
    for (double k = std::ceil(lo / kResolution); k * kResolution < hi; ++k) {
      cuts.push_back((k * kResolution - a[axis]) / (b[axis] - a[axis]));
    }
  }
  std::sort(cuts.begin(), cuts.end());
  std::set<Voxel> voxels;
  for (size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (cuts[i + 1] - cuts[i] > 1e-12) voxels.insert(VoxelOf(a + 0.5 * (cuts[i] + cuts[i + 1]) * (b - a)));
  }
  return voxels;
}

/// The states that every scan's rays should leave, by the plainest rule: the first ray to end in a voxel
/// frees what it crosses on its way to the middle of that voxel; hits win over misses.
class DenseGrid {
 public:
  void Integrate(const core::SpinEvent& spin, double max_range_m, double void_range_m, int miss, int hit) {
    std::set<Voxel> hits, miss_ends, free;
    for (const bool want_hits : {true, false}) {
      for (size_t i = 0; i < spin.scan.size(); ++i) {
        if (spin.scan.kind[i] == core::ReturnKind::kDropout) continue;
        const bool returned = spin.scan.kind[i] == core::ReturnKind::kHit;
        const double range =
            static_cast<double>(spin.scan.range_m[i]) * spin.scan.direction_lidar[i].cast<double>().norm();
        const bool is_hit = returned && range <= max_range_m;
        if (is_hit != want_hits) continue;
        const double length = is_hit ? range : returned ? max_range_m : void_range_m;
        const core::Pose T =
            spin.T_odom_lidar.At(spin.scan.stamp_s + static_cast<double>(spin.scan.time_s[i]));
        const Vec3 d = T.linear() * spin.scan.direction_lidar[i].cast<double>().normalized();
        const Voxel end = VoxelOf(T.translation() + length * d);
        if (!(is_hit ? hits : miss_ends).insert(end).second) continue;
        const auto [x, y, z] = end;
        const auto crossed = Crossed(T.translation(), kResolution * (Vec3(x, y, z).array() + 0.5).matrix());
        for (const Voxel& v : crossed) {
          if (v != end || !is_hit) free.insert(v);
        }
      }
    }
    for (const Voxel& v : hits) Add(v, hit);
    for (const Voxel& v : free) {
      if (hits.count(v) == 0) Add(v, -miss);
    }
  }
  const std::map<Voxel, int>& values() const { return value_; }

 private:
  void Add(const Voxel& v, int delta) {
    int& value = value_[v];
    // What is occupied has a place, the middle, in its two low bits.
    const int sum = std::clamp((value > 0 ? value / 4 * 4 : value) + delta, Field::kMin, 68);
    value = sum > 0 ? sum / 4 * 4 + 2 : sum;
    if (value == 0) value = 1;
  }
  std::map<Voxel, int> value_;
};

TEST(RayIntegrator, EqualsADenseGridExactly) {
  const core::LidarModel lidar = tests::SmallLidar(12, 100);
  core::Rng noise(11);
  IntegratorParams params;
  params.max_range_m = 4.5;
  params.void_range_m = 3.0;
  params.lossless = true;
  DenseGrid grid;
  OccupancyOctree map(kResolution);
  const auto integrator = MakeRayIntegrator<Field>(params);
  for (core::SpinEvent& spin : tests::WalkThrough(tests::FurnishedRoom(), lidar, 5, &noise)) {
    grid.Integrate(spin, params.max_range_m, params.void_range_m, 8, 16);
    spin.scan.columns = static_cast<int>(spin.scan.size());  // unorganised
    spin.scan.rows = 0;
    integrator->Integrate(spin, core::Pose::Identity(), &map);
  }
  ASSERT_GT(grid.values().size(), 20000u);
  size_t wrong = 0, known = 0;
  for (const auto& [v, value] : grid.values())
    wrong += map.At(NodeKey{std::get<0>(v), std::get<1>(v), std::get<2>(v)}) != value;
  EXPECT_EQ(wrong, 0u);
  for (const auto* chunk : map.Chunks()) {
    OccupancyOctree::FineLeaf leaf;
    for (int block = 0; block < kChunkBlocks; ++block) {
      map.Expand(*chunk, block, &leaf);
      for (const int8_t v : leaf.log_odds) known += v != 0;
    }
  }
  EXPECT_EQ(known, grid.values().size());
}

TEST(RayIntegrator, DistancesFollowAPlane) {
  tests::AnalyticWorld world;
  world.AddPlane({1, 0, 0}, 3.0);
  const core::LidarModel lidar = tests::SmallLidar(32, 512);
  auto spin = tests::SpinThrough(world, lidar, 0.0, tests::StandingAt(core::Pose::Identity()));
  spin.scan.columns = static_cast<int>(spin.scan.size());
  spin.scan.rows = 0;
  TsdfOctree map(0.1);
  IntegratorParams params;
  params.void_rays = "ignore";
  MakeRayIntegrator<TsdfField>(params)->Integrate(spin, core::Pose::Identity(), &map);
  const auto at = [&](double x) { return map.At(Vec3(x, 0.05, 0.05)); };
  EXPECT_NEAR(at(2.95).distance * TsdfField::UnitM(0.1), 0.05, 0.02);
  EXPECT_NEAR(at(3.05).distance * TsdfField::UnitM(0.1), -0.05, 0.02);
  EXPECT_NEAR(at(1.05).distance * TsdfField::UnitM(0.1), 0.3, 0.001);
  EXPECT_FALSE(TsdfField::Known(at(3.65)));
}

TEST(RollingMap, MemoryStaysBoundedAndWhatIsNearStays) {
  const core::LidarModel lidar = tests::SmallLidar(12, 128);
  OccupancyOctree map(0.1);
  IntegratorParams params;
  params.void_range_m = 8.0;
  const auto integrator = MakeConeIntegrator<Field>(params, lidar);
  size_t erased = 0, first = 0;
  for (int k = 0; k < 12; ++k) {
    const core::Pose T = core::PoseFromXyzYaw({10.0 * k, 0.0, 0.0}, 0.0);
    integrator->Integrate(tests::SpinThrough(tests::AnalyticWorld{}, lidar, 0.0, tests::StandingAt(T)),
                          core::Pose::Identity(), &map);
    const OccupancyOctree::Counts before = map.Count();
    EXPECT_GT(before.chunks, 0u);
    erased += CropToRange(&map, T.translation(), 12.0);
    EXPECT_TRUE(Field::Free(map.At(Vec3(T.translation() + Vec3(4.0, 0.0, 0.0)))));
    if (k == 3) first = map.Bytes();
    if (k > 3) {
      EXPECT_LT(map.Bytes(), first + first / 2);
    }
  }
  EXPECT_GT(erased, 10u);
  EXPECT_FALSE(Field::Known(map.At(Vec3(0.0, 0.0, 0.0))));
}

}  // namespace
}  // namespace atlas::mapping
