// What frees space and what does not.
#include <gtest/gtest.h>

#include "mapping/integrator/integrator.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = OccupancyField;

/// A LiDAR at the origin that sees one thing, and what it makes of it.
struct Stand {
  explicit Stand(const tests::AnalyticWorld& world, double resolution_m = 0.1)
      : spin(tests::SpinThrough(world, lidar, 0.0, tests::StandingAt(core::Pose::Identity()))),
        map(resolution_m) {}

  void Integrate(int times = 1) {
    const auto integrator = MakeConeIntegrator<Field>(params, lidar);
    for (int k = 0; k < times; ++k) integrator->Integrate(spin, core::Pose::Identity(), &map);
  }
  /// The farthest free voxel centre along a beam.
  double FreeTo(int row, int column) const {
    const Vec3 d = lidar.Direction(row, column);
    double last = 0.0;
    for (double t = 0.5; t < 80.0; t += 0.05) {
      if (Field::Free(map.At(Vec3(t * d)))) last = t;
    }
    return last;
  }

  core::LidarModel lidar = tests::SmallLidar();
  core::SpinEvent spin;
  IntegratorParams params;
  OccupancyOctree map;
};

TEST(IntegratorFreeSpace, VoidRaysFreeOnlyAsFarAsTheyAreTrusted) {
  Stand stand{tests::AnalyticWorld{}};
  stand.params.void_range_m = 7.0;
  stand.Integrate();
  const double to = stand.FreeTo(10, 40);
  EXPECT_GT(to, 6.5);
  EXPECT_LT(to, 7.2);
}

TEST(IntegratorFreeSpace, IgnoredVoidRaysAreNoEvidence) {
  Stand stand{tests::AnalyticWorld{}};
  stand.params.void_rays = "ignore";
  stand.Integrate();
  EXPECT_EQ(stand.map.Count().uniform_known + stand.map.Count().fine + stand.map.Count().coarse, 0u);
}

TEST(IntegratorFreeSpace, DropoutsAreNoInformation) {
  tests::AnalyticWorld world;
  world.AddPlane({1, 0, 0}, 9.03);
  Stand stand{world};
  std::fill(stand.spin.scan.kind.begin(), stand.spin.scan.kind.end(), core::ReturnKind::kDropout);
  stand.Integrate();
  EXPECT_EQ(stand.map.Count().uniform_known + stand.map.Count().fine + stand.map.Count().coarse, 0u);
}

TEST(IntegratorFreeSpace, ADroppedBeamFreesNothingWhereNeighboursDoNotReach) {
  Stand stand{tests::AnalyticWorld{}};
  stand.params.void_range_m = 30.0;
  const int row = 12, column = 40;
  stand.spin.scan.kind[static_cast<size_t>(row * stand.lidar.columns + column)] = core::ReturnKind::kDropout;
  stand.Integrate();
  const Vec3 d = stand.lidar.Direction(row, column);
  // Beams are 2 degrees apart: 0.7 m at 20 m, seven voxels.
  EXPECT_FALSE(Field::Known(stand.map.At(Vec3(20.0 * d))));
  EXPECT_TRUE(Field::Free(stand.map.At(Vec3(20.0 * stand.lidar.Direction(row, column + 2)))));
}

TEST(IntegratorFreeSpace, ReturnsBeyondTheRangeAreMissesUpToIt) {
  tests::AnalyticWorld world;
  world.AddPlane({1, 0, 0}, 40.0);
  Stand stand{world};
  stand.params.max_range_m = 12.0;
  stand.params.void_rays = "ignore";
  stand.Integrate();
  const double to = stand.FreeTo(12, 0);
  EXPECT_GT(to, 11.5);
  EXPECT_LT(to, 12.2);
  EXPECT_FALSE(Field::Known(stand.map.At(Vec3(40.05, 0, 0))));
}

TEST(IntegratorFreeSpace, EveryVoxelThatAScanHitIsRaisedAndNeverFreed) {
  const tests::AnalyticWorld room = tests::FurnishedRoom();
  const core::LidarModel lidar = tests::SmallLidar();
  core::Rng noise(3);
  for (const double resolution : {0.05, 0.13, 0.26}) {
    OccupancyOctree map(resolution);
    const auto integrator = MakeConeIntegrator<Field>({}, lidar);
    for (const core::SpinEvent& spin : tests::WalkThrough(room, lidar, 6, &noise)) {
      std::vector<std::pair<Vec3, int8_t>> before;
      for (size_t i = 0; i < spin.scan.size(); ++i) {
        if (spin.scan.kind[i] != core::ReturnKind::kHit || spin.scan.range_m[i] > 60.0f) continue;
        const core::Pose T =
            spin.T_odom_lidar.At(spin.scan.stamp_s + static_cast<double>(spin.scan.time_s[i]));
        const Vec3 p = T * (spin.scan.range_m[i] * spin.scan.direction_lidar[i]).cast<double>();
        // Rounding may move what lies on the face of a voxel.
        const Vec3 inside = p / resolution - (p / resolution).array().floor().matrix();
        if (inside.minCoeff() < 0.01 || inside.maxCoeff() > 0.99) continue;
        before.emplace_back(p, map.At(p));
      }
      ASSERT_GT(before.size(), 2000u);
      integrator->Integrate(spin, core::Pose::Identity(), &map);
      size_t matched = 0;
      for (const auto& [p, old] : before) {
        const int8_t now = map.At(p);
        // But for the bits that say where in the voxel the surface is.
        if (Field::LogOdds(now) > Field::LogOdds(old) || now > Field::kMax - Field::kPlaces) ++matched;
      }
      EXPECT_EQ(matched, before.size()) << resolution;
    }
  }
}

TEST(IntegratorFreeSpace, WallsAreNotThickened) {
  tests::AnalyticWorld world;
  world.AddPlane({1, 0, 0}, 18.33);
  Stand stand{world, 0.1};
  stand.params.void_rays = "ignore";
  stand.Integrate(5);
  for (int column = -8; column <= 8; ++column) {
    const Vec3 d = stand.lidar.Direction(12, (column + stand.lidar.columns) % stand.lidar.columns);
    const Vec3 p = 18.33 / d.x() * d;
    double first = 1e9, last = -1e9;
    for (double x = -1.0; x < 2.0; x += 0.01) {
      if (!Field::Occupied(stand.map.At(Vec3(p + x * d)))) continue;
      first = std::min(first, x);
      last = std::max(last, x);
    }
    EXPECT_LT(first, 0.01);
    EXPECT_GT(last, -0.01);
    EXPECT_LT(last - first, 0.30);  // thesis: lambda_r d would be 0.37 m
  }
}

TEST(IntegratorFreeSpace, NothingIsKeptOutsideTheRegion) {
  Stand stand{tests::FurnishedRoom(), 0.07};
  const auto whole = [&] {
    Stand s{tests::FurnishedRoom(), 0.07};
    s.Integrate(2);
    return std::move(s.map);
  }();
  const core::Box3 region{{-0.4, -2.2, -0.9}, {2.93, 1.1, 0.77}};
  stand.params.region_map = region;
  stand.Integrate(2);
  core::Rng rng(1);
  size_t inside = 0, different = 0;
  for (int i = 0; i < 40000; ++i) {
    const Vec3 p(rng.Uniform(-4, 4), rng.Uniform(-3, 3), rng.Uniform(-1.5, 1.5));
    const NodeKey key = stand.map.KeyAt(p);
    const core::Box3 voxel{0.07 * Vec3(key.x, key.y, key.z), 0.07 * Vec3(key.x + 1, key.y + 1, key.z + 1)};
    const bool overlaps =
        (voxel.max.array() > region.min.array()).all() && (voxel.min.array() < region.max.array()).all();
    if (!overlaps) {
      EXPECT_FALSE(Field::Known(stand.map.At(p)));
    } else {
      ++inside;
      different += Field::Occupied(stand.map.At(p)) != Field::Occupied(whole.At(p)) ? 1 : 0;
    }
  }
  EXPECT_GT(inside, 500u);
  // Where hits are many a voxel, which of them are followed depends on those that are taken with them.
  EXPECT_LE(different, inside / 1000);
}

template <typename AnyField>
void ExpectThreeToBeTwo() {
  const core::LidarModel lidar = tests::SmallLidar();
  const auto spins = tests::WalkThrough(tests::FurnishedRoom(), lidar, 1);
  const auto digest = [&](int max_scale) {
    IntegratorParams params;
    params.max_scale = max_scale;
    return tests::DigestOf(tests::MapOf<AnyField>(spins, lidar, params, 0.025));
  };
  EXPECT_TRUE(digest(3) == digest(2));
  EXPECT_FALSE(digest(3) == digest(4)) << "beams are four voxels apart somewhere";
}

TEST(IntegratorFreeSpace, CellsAreOneTwoOrFourVoxelsWide) {
  ExpectThreeToBeTwo<OccupancyField>();
  ExpectThreeToBeTwo<TsdfField>();
}

}  // namespace
}  // namespace atlas::mapping
