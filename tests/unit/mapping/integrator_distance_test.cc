// Distance maps against the closed forms of what was scanned.
#include <gtest/gtest.h>

#include "mapping/integrator/integrator.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = TsdfField;

struct Errors {
  double mean_voxels = 0.0;
  size_t count = 0;
};

/// Of the voxels within a voxel of the surface, against its signed distance.
template <typename Distance>
Errors ErrorsOf(const TsdfOctree& map, const core::Box3& box, const Distance& distance) {
  Errors e;
  const double r = map.resolution_m();
  for (double x = box.min.x(); x < box.max.x(); x += r) {
    for (double y = box.min.y(); y < box.max.y(); y += r) {
      for (double z = box.min.z(); z < box.max.z(); z += r) {
        const NodeKey key = map.KeyAt({x, y, z});
        const Field::Value v = map.At(key);
        const double truth = distance(map.CenterOf(key));
        // What no beam met a surface near is free as far as the truncation, and no distance.
        if (!Field::Known(v) || std::abs(truth) > r || v.distance * Field::UnitM(r) > 2.99 * r) continue;
        e.mean_voxels += std::abs(v.distance * Field::UnitM(r) - truth) / r;
        ++e.count;
      }
    }
  }
  e.mean_voxels /= static_cast<double>(std::max<size_t>(e.count, 1));
  return e;
}

std::vector<core::SpinEvent> Around(const tests::AnalyticWorld& world, const core::LidarModel& lidar) {
  std::vector<core::SpinEvent> spins;
  for (int k = 0; k < 6; ++k) {
    const double a = 2.0 * core::kPi * k / 6;
    const core::Pose T = core::PoseFromXyzYaw({3.0 * std::cos(a), 3.0 * std::sin(a), 0.1 * k}, 0.7 * k);
    spins.push_back(tests::SpinThrough(world, lidar, 0.0, tests::StandingAt(T)));
  }
  return spins;
}

constexpr double kResolution = 0.08;

TEST(IntegratorDistances, PlaneWithinATenthOfAVoxel) {
  tests::AnalyticWorld world;
  const Vec3 n = Vec3(0.2, 0.1, 1.0).normalized();
  world.AddPlane(n, -0.9);
  const core::LidarModel lidar = tests::SmallLidar(32, 512);
  const auto map = tests::MapOf<Field>(Around(world, lidar), lidar, {}, kResolution);
  const Errors e = ErrorsOf(map, {{-3, -3, -2}, {3, 3, 0}}, [&](const Vec3& p) { return n.dot(p) + 0.9; });
  EXPECT_GT(e.count, 3000u);
  EXPECT_LT(e.mean_voxels, 0.1);
}

TEST(IntegratorDistances, SphereWithinAFifthOfAVoxel) {
  tests::AnalyticWorld world;
  world.AddSphere({0, 0, 0.2}, 0.8);
  const core::LidarModel lidar = tests::SmallLidar(32, 512);
  const auto map = tests::MapOf<Field>(Around(world, lidar), lidar, {}, kResolution);
  const Errors e = ErrorsOf(map, {{-1, -1, -0.8}, {1, 1, 1.2}},
                            [](const Vec3& p) { return (p - Vec3(0, 0, 0.2)).norm() - 0.8; });
  EXPECT_GT(e.count, 500u);
  EXPECT_LT(e.mean_voxels, 0.2);
}

TEST(IntegratorDistances, FacesOfABoxWithinATenthOfAVoxel) {
  tests::AnalyticWorld world;
  world.AddBox({{-0.83, -0.71, -0.6}, {0.77, 0.69, 0.81}});
  const core::LidarModel lidar = tests::SmallLidar(32, 512);
  const auto map = tests::MapOf<Field>(Around(world, lidar), lidar, {}, kResolution);
  // The face x = 0.77, away from its edges.
  const Errors e =
      ErrorsOf(map, {{0.5, -0.4, -0.3}, {1.0, 0.4, 0.5}}, [](const Vec3& p) { return p.x() - 0.77; });
  EXPECT_GT(e.count, 100u);
  EXPECT_LT(e.mean_voxels, 0.1);
}

TEST(IntegratorDistances, FreeSpaceIsWrittenAndBehindSurfacesIsUnknown) {
  tests::AnalyticWorld world;
  world.AddPlane({1, 0, 0}, 6.0);
  const core::LidarModel lidar = tests::SmallLidar();
  const auto spin = tests::SpinThrough(world, lidar, 0.0, tests::StandingAt(core::Pose::Identity()));
  const auto map = tests::MapOf<Field>({spin}, lidar, {}, kResolution);
  EXPECT_TRUE(Field::Free(map.At(Vec3(3.0, 0.5, 0.0))));
  EXPECT_NEAR(map.At(Vec3(3.0, 0.5, 0.0)).distance * Field::UnitM(kResolution), 3.0 * kResolution, 1e-3);
  EXPECT_TRUE(Field::Occupied(map.At(Vec3(6.1, 0.0, 0.0))));
  EXPECT_FALSE(Field::Known(map.At(Vec3(7.5, 0.0, 0.0))));
}

}  // namespace
}  // namespace atlas::mapping
