// Thesis 4.5.3: rays at their own times.
#include <gtest/gtest.h>

#include "mapping/integrator/integrator.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = OccupancyField;

/// Mean distance of the occupied voxels from the nearest wall of a bare room, in voxels.
double WallError(const core::PoseTrajectory& path, bool motion_aware) {
  tests::AnalyticWorld room;
  for (const double side : {-1.0, 1.0}) {
    room.AddPlane({1, 0, 0}, 4.03 * side);
    room.AddPlane({0, 1, 0}, 3.07 * side);
    room.AddPlane({0, 0, 1}, 1.51 * side);
  }
  const core::LidarModel lidar = tests::SmallLidar();
  constexpr double kResolution = 0.06;
  IntegratorParams params;
  params.motion_aware = motion_aware;
  std::vector<core::SpinEvent> spins;
  for (int k = 0; k < 5; ++k) spins.push_back(tests::SpinThrough(room, lidar, 0.1 * k, path));
  const auto map = tests::MapOf<Field>(spins, lidar, params, kResolution);
  double sum = 0.0;
  size_t count = 0;
  for (double x = -5; x < 5; x += kResolution) {
    for (double y = -4; y < 4; y += kResolution) {
      for (double z = -2; z < 2; z += kResolution) {
        if (!Field::Occupied(map.At(Vec3(x, y, z)))) continue;
        const NodeKey key = map.KeyAt({x, y, z});
        const Vec3 c = map.CenterOf(key);
        const double off = std::min({std::abs(std::abs(c.x()) - 4.03), std::abs(std::abs(c.y()) - 3.07),
                                     std::abs(std::abs(c.z()) - 1.51)});
        sum += off / kResolution;
        ++count;
      }
    }
  }
  EXPECT_GT(count, 2000u);
  return sum / static_cast<double>(count);
}

TEST(IntegratorMotion, FastTurnNoLongerSmearsWalls) {
  core::PoseTrajectory path;
  for (int k = 0; k <= 60; ++k) path.Add(0.01 * k, core::PoseFromXyzYaw({0.2, 0.1, 0.0}, 2.0 * 0.01 * k));
  const double with = WallError(path, true), without = WallError(path, false);
  EXPECT_LT(with, 0.9);
  EXPECT_GT(without, 1.5 * with);
}

TEST(IntegratorMotion, RollingSensorNoLongerSmearsWalls) {
  core::PoseTrajectory path;
  for (int k = 0; k <= 120; ++k) {
    const double roll = core::Radians(40.0) * std::sin(9.0 * 0.005 * k);
    path.Add(0.005 * k, core::MakePose(core::RotationFromYawPitchRoll(0.3, 0.0, roll), {0.2, 0.1, 0.0}));
  }
  const double with = WallError(path, true), without = WallError(path, false);
  EXPECT_LT(with, 0.9);
  EXPECT_GT(without, 1.5 * with);
}

TEST(IntegratorMotion, AStandingSensorIsTheSameEitherWay) {
  const core::LidarModel lidar = tests::SmallLidar();
  const auto spin =
      tests::SpinThrough(tests::FurnishedRoom(), lidar, 0.0, tests::StandingAt(core::Pose::Identity()));
  IntegratorParams aware, unaware;
  unaware.motion_aware = false;
  EXPECT_TRUE(tests::DigestOf(tests::MapOf<Field>({spin}, lidar, aware, 0.08)) ==
              tests::DigestOf(tests::MapOf<Field>({spin}, lidar, unaware, 0.08)));
}

}  // namespace
}  // namespace atlas::mapping
