// The elevation map on even ground: heights, noise, motion, the rolling window, footprints.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/placed_spins.h"
#include "tests/unit/mapping/terrain_fixture.h"

namespace atlas::mapping {
namespace {

using core::PoseFromXyzYaw;
using core::Radians;
using core::Vec2;
using core::Vec3;
using tests::PatchWorld;
using tests::TerrainSensors;

struct Statistics {
  double known_share = 0.0, mean = 0.0, deviation = 0.0, traversable_share = 0.0;
};

/// Of the export's cells from `inner` to `outer` metres about `centre`.
Statistics RingStatistics(const ElevationMap& map, const Vec2& centre, double inner, double outer) {
  const ElevationMap::Grid grid = map.Export();
  double cells = 0, known = 0, traversable = 0, sum = 0, squares = 0;
  for (int r = 0; r < grid.rows; ++r) {
    for (int c = 0; c < grid.cols; ++c) {
      const double distance = (grid.origin + grid.cell_m * Vec2(c + 0.5, r + 0.5) - centre).norm();
      if (distance < inner || distance >= outer) continue;
      const size_t i = static_cast<size_t>(r * grid.cols + c);
      cells += 1;
      traversable += grid.traversability[i] > 0.8f;
      if (std::isnan(grid.height_m[i])) continue;
      const double height = static_cast<double>(grid.height_m[i]);
      known += 1;
      sum += height;
      squares += height * height;
    }
  }
  const double mean = sum / known;
  return {known / cells, mean, std::sqrt(squares / known - mean * mean), traversable / cells};
}

TEST(TerrainMap, FlatGroundIsWithinACentimetreAndTraversableToFiveMetres) {
  PatchWorld world = FlatWorld();
  TerrainSensors sensors(&world, 1);
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  const core::Pose T = PoseFromXyzYaw({0.3, -0.2, kStance}, 0.7);
  map.InitialiseUnderRobot(T);
  sensors.Sweep(T, Radians(40), 60, &map);
  map.Update();
  for (const double inner : {0.0, 1.0, 2.0, 3.0, 4.0}) {
    const Statistics ring = RingStatistics(map, {0.3, -0.2}, inner, inner + 1);
    EXPECT_GT(ring.known_share, 0.9) << inner;
    EXPECT_GT(ring.traversable_share, 0.85) << inner;
    EXPECT_LT(std::abs(ring.mean), 0.005) << inner;
    EXPECT_LT(ring.deviation, 0.005) << inner;
  }
  const auto ground = map.At(-0.67, 0.95);  // abeam
  EXPECT_TRUE(ground.known);
  EXPECT_TRUE(ground.steppable);
  EXPECT_NEAR(ground.height_m, 0.0, 0.01);
  EXPECT_NEAR(map.SurfaceAt({1.5, 1.5, 0.0}).slope_rad, 0.0, Radians(0.5));
  EXPECT_LT(map.SurfaceAt({1.5, 1.5, 0.0}).roughness_m, 0.005);
}

TEST(TerrainMap, RollingSpinIsUndistortedByEachRaysOwnTime) {
  PatchWorld world = FlatWorld();
  TerrainSensors sensors(&world, 2);
  sensors.range_sigma_m = 0.0;
  const core::Pose T = PoseFromXyzYaw({0, 0, kStance}, 0);
  const auto rolling = [&](double t) {
    return core::Pose(T *
                      core::MakePose(core::RotationFromYawPitchRoll(0, 0, 3.0 * (t - 0.05)), Vec3::Zero()));
  };
  // 17 degrees within the revolution: with one pose for all rays the ground at 3 m would tilt by 0.4 m.
  core::SpinEvent spin = sensors.Spin(0.0, rolling);
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  map.OnState(sensors.State(0.0, T));
  map.OnSpin(tests::Shared(spin));
  map.Update();
  const Statistics truth = RingStatistics(map, {0, 0}, 1.0, 4.0);
  EXPECT_GT(truth.known_share, 0.02);
  EXPECT_LT(truth.deviation, 0.002);

  core::PoseTrajectory frozen;
  frozen.Add(0.0, spin.T_odom_lidar.At(0.0));
  spin.T_odom_lidar = frozen;
  ElevationMap distorted(TerrainParams{}, core::RobotExtent{});
  distorted.OnState(sensors.State(0.0, T));
  distorted.OnSpin(tests::Shared(spin));
  distorted.Update();
  EXPECT_GT(RingStatistics(distorted, {0, 0}, 1.0, 4.0).deviation, 0.05);
}

TEST(TerrainMap, WindowThatMovedTenMetresKeepsCellsWhereTheyAre) {
  PatchWorld world;  // 1 cm a metre, so that a shifted cell shows
  const Vec3 slope(60, 0, 0.6);
  world.patches.push_back({{-30, -30, -0.3}, slope, {0, 60, 0}});
  TerrainSensors sensors(&world, 3);
  sensors.column_stride = 3;
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  const auto ground_at = [](double x) { return 0.01 * x; };
  for (int step = 0; step <= 12; ++step) {
    const double x = 10.0 * step / 12.0, y = -7.0 * step / 12.0;
    sensors.Sweep(PoseFromXyzYaw({x, y, ground_at(x) + kStance}, 0), Radians(40), 20, &map);
  }
  map.Update();
  EXPECT_NEAR(map.Window().Center().x(), 10.0, 0.05);
  EXPECT_NEAR(map.Window().Center().y(), -7.0, 0.05);
  int known = 0;
  for (double x = 4.2; x < 15.8; x += 0.11) {
    for (double y = -12.8; y < -1.2; y += 0.11) {
      const auto ground = map.At(x, y);
      if (!ground.known) continue;
      ++known;
      ASSERT_NEAR(ground.height_m, ground_at(x), 0.02) << x << " " << y;
    }
  }
  EXPECT_GT(known, 7000);
  EXPECT_FALSE(map.At(0.0, 0.0).known);
}

TEST(TerrainMap, DepthImageFillsTheNearFieldAndSkipsPixelsWithoutMeasurement) {
  PatchWorld world = FlatWorld();
  TerrainSensors sensors(&world, 4);
  const core::Pose T = PoseFromXyzYaw({0, 0, kStance}, 0);
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  map.InitialiseUnderRobot(T);
  map.OnState(sensors.State(0.0, T));
  map.Update();
  EXPECT_FALSE(map.At(1.3, 0.0).known);
  map.OnDepth(sensors.Depth(T, 0.4, Radians(30), 3));
  core::DepthEvent blind = sensors.Depth(T, 0.4, Radians(30), 0);
  blind.image.depth_m.assign(blind.image.depth_m.size(), std::numeric_limits<float>::quiet_NaN());
  map.OnDepth(blind);
  map.Update();
  for (double x = 1.0; x < 2.0; x += 0.1) {
    ASSERT_TRUE(map.At(x, 0.1).known) << x;
    EXPECT_NEAR(map.At(x, 0.1).height_m, 0.0, 0.01) << x;
  }
}

TEST(TerrainMap, StartsAsSolidGroundUnderTheRobotAndUnknownBeyond) {
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  EXPECT_FALSE(map.At(0, 0).known);
  EXPECT_FALSE(map.CircleFree({0, 0, 0}));
  map.InitialiseUnderRobot(PoseFromXyzYaw({5, 5, 1.0 + kStance}, 0));
  map.Update();
  EXPECT_TRUE(map.At(5, 5).steppable);
  EXPECT_NEAR(map.At(5.2, 5.1).height_m, 1.0, 1e-6);
  EXPECT_TRUE(map.CircleFree({5, 5, 1.0}));
  EXPECT_TRUE(map.FootprintFree({5, 5, 1.0}, 0.4));
  EXPECT_FALSE(map.CircleFree({5, 5, 0.4})) << "below the ground";
  EXPECT_FALSE(map.CircleFree({6.5, 5, 1.0}));
  EXPECT_EQ(map.Traversability({7, 5, 1.0}), 0.0);
  EXPECT_EQ(map.Traversability({100, 5, 1.0}), 0.0);
}

TEST(TerrainMap, FeetMeasureTheGroundTheyStandOn) {
  PatchWorld world;
  TerrainSensors sensors(&world, 5);
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  map.InitialiseUnderRobot(PoseFromXyzYaw({0, 0, kStance}, 0));
  map.OnState(sensors.State(0.0, PoseFromXyzYaw({0, 0, kStance + 0.05}, 0)));
  map.Update();
  EXPECT_NEAR(map.At(0.34, 0.235).height_m, 0.05, 0.02);
}

TEST(TerrainMap, FootprintIsFreeExactlyWhereNoBlockedCellTouchesIt) {
  PatchWorld world = FlatWorld();
  world.AddBox({1.5, 0.4, 0}, {1.7, 0.6, 1.0});
  world.AddBox({0.2, 1.8, 0}, {1.0, 1.9, 0.5});
  TerrainSensors sensors(&world, 6);
  const core::RobotExtent robot;
  TerrainParams params;
  ElevationMap map(params, robot);
  const core::Pose T = PoseFromXyzYaw({0, 0, kStance}, 0);
  map.InitialiseUnderRobot(T);
  sensors.Sweep(T, Radians(40), 40, &map);
  map.Update();
  // The worst cell whose centre lies in the footprint grown by `rim`.
  const auto worst = [&](const Vec2& p, double yaw, double rim) {
    double least = 1.0;
    const Eigen::Rotation2Dd R(-yaw);
    for (int iy = -60; iy < 110; ++iy) {
      for (int ix = -60; ix < 110; ++ix) {
        const Vec2 cell = params.cell_m * Vec2(ix + 0.5, iy + 0.5), local = R * (cell - p);
        if (std::abs(local.x()) > robot.half_length_m + rim ||
            std::abs(local.y()) > robot.half_width_m + rim) {
          continue;
        }
        least = std::min(least, map.Traversability(Place(cell)));
      }
    }
    return least;
  };
  core::Rng rng(9);
  int free = 0, blocked = 0;
  for (int k = 0; k < 300; ++k) {
    const Vec2 p(rng.Uniform(-1, 3), rng.Uniform(-1, 3));
    const double yaw = rng.Uniform(-3, 3);
    if (map.FootprintFree(Place(p), yaw)) {
      ++free;
      EXPECT_GE(worst(p, yaw, 0.0), params.min_traversability) << p.transpose();
    } else {
      ++blocked;
      EXPECT_LT(worst(p, yaw, params.edge_clearance_m), params.min_traversability) << p.transpose();
    }
  }
  EXPECT_GT(free, 30);
  EXPECT_GT(blocked, 30);
}

}  // namespace
}  // namespace atlas::mapping
