#include "experiments/judge/attainable.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "experiments/identity/experiment_config.h"
#include "experiments/judge/sweep_aim.h"
#include "tests/support/box_world.h"

namespace atlas::experiments {
namespace {

using core::Box3;
using core::Pose;
using core::Vec3;
using core::Vec3f;
using tests::BoxWorld;
using tests::SmallWorld;
using tests::TestLidar;
using tests::TestRobot;

TEST(ReachableSet, OpenFloorAroundABlockHasItsClosedFormArea) {
  BoxWorld world;
  world.Add({-4, -4, -0.5}, {4, 4, 0});
  world.Add({-0.5, -0.5, 0}, {0.5, 0.5, 1}, true);
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-2.0, 0.0, 0.0}, 0.0);
  const robots::RobotSpec robot = TestRobot();
  Box3 region = world.scene.bounds;
  region.max.z() += 1.0;
  const ReachableSet set = FindReachable(world.scene, robot, region, {});
  const double r = robot.footprint_radius_m;
  const double open = (8.0 - 2.0 * r) * (8.0 - 2.0 * r), grown_block = 1.0 + 4.0 * r + core::kPi * r * r;
  EXPECT_NEAR(set.AreaM2(), open - grown_block, 0.05 * open);
  EXPECT_TRUE(set.ReachableAt({0.0, 1.2}));
  EXPECT_FALSE(set.ReachableAt({0.0, 0.95}));
  EXPECT_FALSE(set.ReachableAt({3.6, 0.0}));
}

TEST(ReachableSet, PitsHighKerbsAndLowCeilingsAreNotEntered) {
  BoxWorld world;
  world.Add({-4, -4, -1.5}, {4, 4, -1.0});          // floor of the pit
  world.Add({-4, -4, -1.0}, {0, 4, 0});             // the robot's half
  world.Add({1.5, -4, -1.0}, {4, -1, 0});           // beyond the pit
  world.Add({-3.9, 2.0, 0}, {-0.1, 4, 0.3});        // a kerb too high
  world.Add({-3.9, -4.0, 0.6}, {-0.1, -2.0, 0.7});  // a ceiling too low
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-2.0, 0.0, 0.0}, 0.0);
  Box3 region = world.scene.bounds;
  const ReachableSet set = FindReachable(world.scene, TestRobot(), region, {});
  EXPECT_TRUE(set.ReachableAt({-2.0, 0.5}));
  EXPECT_FALSE(set.ReachableAt({0.5, 0.0}));
  EXPECT_FALSE(set.ReachableAt({2.7, -2.5}));
  EXPECT_FALSE(set.ReachableAt({-2.0, 3.0}));
  EXPECT_FALSE(set.ReachableAt({-2.0, -3.0}));
  EXPECT_FALSE(set.ReachableAt({-0.4, 0.0}));  // circle over the edge
}

TEST(ReachableSet, AKerbBelowTheStepIsClimbed) {
  BoxWorld world;
  world.Add({-4, -3, -0.5}, {4, 3, 0});
  world.Add({0, -3, 0}, {4, 3, 0.1});
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-2.0, 0.0, 0.0}, 0.0);
  Box3 region = world.scene.bounds;
  region.max.z() += 1.0;
  const ReachableSet set = FindReachable(world.scene, TestRobot(), region, {});
  EXPECT_TRUE(set.ReachableAt({2.0, 0.0}));
  int row, col;
  ASSERT_TRUE(set.CellUnder({2.0, 0.0}, &row, &col));
  EXPECT_NEAR(set.ground_m[set.IndexOf(row, col)], 0.1, 1e-6);
}

TEST(SweepAim, FieldOfViewIsFiftyFiveDegreesAbeam) {
  const robots::RobotSpec robot = TestRobot();
  const SweepAim aim(robot, core::FindLidarModel("vlp16"), 8, core::Radians(40.0));
  const Vec3 sensor(0, 0, aim.sensor_height_m());
  const auto sees = [&](double azimuth_deg, double elevation_deg) {
    const double a = core::Radians(azimuth_deg), e = core::Radians(elevation_deg);
    SweepAim::Shot shot;
    const Vec3 far =
        sensor + 1000.0 * Vec3(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
    return aim.At(Vec3::Zero(), far.cast<float>(), 0, &shot);
  };
  for (double azimuth = 0.0; azimuth < 360.0; azimuth += 45.0) {
    EXPECT_TRUE(sees(azimuth, 54.5));
    EXPECT_FALSE(sees(azimuth, 55.5));
    EXPECT_TRUE(sees(azimuth, -54.5));
    EXPECT_FALSE(sees(azimuth, -55.5));
  }
  EXPECT_TRUE(sees(22.5, 52.0));  // between two headings the view is a little lower
  EXPECT_FALSE(sees(22.5, 54.5));
}

TEST(SweepAim, TheShotLeavesTheRolledSensorAndMeetsTheTarget) {
  const robots::RobotSpec robot = TestRobot();
  const SweepAim aim(robot, core::FindLidarModel("vlp16"), 8, core::Radians(40.0));
  const Vec3 ground(1.0, -2.0, 0.3), target(2.5, 0.4, 2.0);
  for (int variant = 0; variant < 3; ++variant) {
    SweepAim::Shot shot;
    ASSERT_TRUE(aim.At(ground, target.cast<float>(), variant, &shot));
    EXPECT_LT((shot.origin + shot.distance_m * shot.direction - target.cast<float>()).norm(), 1e-4f);
    const double lever = (shot.origin.cast<double>() - (ground + Vec3(0, 0, robot.stance_height_m))).norm();
    EXPECT_NEAR(lever, robot.T_base_lidar.translation().norm(), 1e-5);
  }
}

TEST(Attainable, ABoxInTheOpenShowsItsSidesAndHidesItsHighTop) {
  BoxWorld world;
  world.Add({-4, -4, -0.5}, {4, 4, 0});
  world.Add({-0.5, -0.4, 0}, {0.5, 0.4, 1.5}, true);
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-2.0, 0.0, 0.0}, 0.0);
  const scenes::GroundTruth truth = world.Truth(0.01);
  const Attainable set = ComputeAttainable(world.scene, truth, TestRobot(), core::FindLidarModel("vlp16"), {},
                                           world.Caster(), nullptr);
  const std::vector<PartCoverage> faces = CoverageByPart(truth, set.attainable);
  for (int side = 0; side < 4; ++side) EXPECT_GT(faces[static_cast<size_t>(side)].share(), 0.999);
  // The top lies above the sensor, the bottom on the ground: no return comes from their outer side.
  EXPECT_EQ(faces[5].share(), 0.0);
  EXPECT_EQ(faces[4].share(), 0.0);
}

TEST(Attainable, EqualsTheUnionOfDenseSweeps) {
  const BoxWorld world = SmallWorld();
  const scenes::GroundTruth truth = world.Truth(0.015);
  const robots::RobotSpec robot = TestRobot();
  const core::LidarModel lidar = TestLidar();
  AttainableOptions options;
  options.lattice_m = 1.0;
  const Attainable set =
      ComputeAttainable(world.scene, truth, robot, lidar, options, world.Caster(), nullptr);

  CoverageScorer scorer(std::make_shared<PointGrid>(truth.points, 2.0 * options.radius_m), truth,
                        options.radius_m);
  const ReachableSet reachable = ReachableForScanning(world.scene, robot, lidar, options);
  const std::vector<Vec3> positions =
      LatticePositions(reachable, world.scene.T_map_spawn.translation(), options.lattice_m);
  ASSERT_GE(positions.size(), 10u);
  EXPECT_EQ(set.positions, positions.size());
  const int rolls = 60;
  for (const Vec3& ground : positions) {
    mapping::ReturnCloud hits;
    for (int heading = 0; heading < 8; ++heading) {
      for (int k = 0; k < rolls; ++k) {
        const double roll = core::Radians(-40.0 + 80.0 * (k + 0.5) / rolls);
        const Pose T_map_lidar =
            core::MakePose(core::RotationFromYawPitchRoll(heading * core::kPi / 4.0, 0.0, roll),
                           ground + Vec3(0, 0, robot.stance_height_m)) *
            robot.T_base_lidar;
        for (int row = 0; row < lidar.rows(); ++row) {
          for (int column = 0; column < lidar.columns; ++column) {
            const double e = lidar.elevation_rad[static_cast<size_t>(row)],
                         a = -2.0 * core::kPi * column / lidar.columns;
            const Vec3 d(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
            const core::Ray ray{T_map_lidar.translation().cast<float>(),
                                (T_map_lidar.linear() * d).cast<float>()};
            const float range = world.RangeOf(ray, 20.0f);
            if (range >= lidar.min_range_m) hits.Add(ray.origin + range * ray.direction, ray.origin);
          }
        }
      }
    }
    scorer.AddReturns(hits.points, hits.origins, Pose::Identity());
  }
  size_t differ = 0, missed = 0;
  for (size_t i = 0; i < truth.points.size(); ++i) {
    differ += scorer.covered()[i] != set.attainable[i];
    missed += scorer.covered()[i] != 0 && set.attainable[i] == 0;
  }
  const double n = static_cast<double>(truth.points.size());
  RecordProperty("differ_permille", static_cast<int>(1e3 * static_cast<double>(differ) / n));
  EXPECT_LT(static_cast<double>(differ) / n, 0.02);
  EXPECT_NEAR(set.coverage, scorer.coverage_raw(), 0.01);
  EXPECT_LT(set.coverage, 0.99);  // something is hidden, or this shows nothing
}

/// Expected rays within the radius of a point on a box in the open, all lattice positions together: density
/// times the disc's solid angle, wherever the face is turned to the sensor and a beam can be.
std::pair<double, double> ExpectedRays(const BoxWorld& world, const Vec3f& p, const Vec3f& normal,
                                       const AttainableOptions& options) {
  const robots::RobotSpec robot = TestRobot();
  const core::LidarModel lidar = core::FindLidarModel("vlp16");
  const SweepAim aim(robot, lidar, options.headings, core::Radians(options.sweep_roll_deg));
  const double density = aim.RaysPerSteradian(lidar, options.headings, options.sweep_period_s);
  const ReachableSet reachable = ReachableForScanning(world.scene, robot, lidar, options);
  double sum = 0.0, most = 0.0;
  for (const Vec3& ground :
       LatticePositions(reachable, world.scene.T_map_spawn.translation(), options.lattice_m)) {
    SweepAim::Shot shot;
    if (!aim.At(ground, p, 0, &shot)) continue;
    const double cosine = -static_cast<double>(normal.dot(shot.direction));
    if (cosine <= 0.0) continue;
    const double d = static_cast<double>(shot.distance_m);
    const double rays = density * core::kPi * options.radius_m * options.radius_m * cosine / (d * d);
    sum += rays;
    most = std::max(most, rays);
  }
  return {sum, most};
}

TEST(Attainable, ExpectedRaysOfAllPositionsAddUp) {
  BoxWorld world;
  world.Add({-4, -4, -0.5}, {4, 4, 0});
  world.Add({-0.2, -0.2, 0}, {0.2, 0.2, 1.0}, true);
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-2.0, 0.0, 0.0}, 0.0);
  const scenes::GroundTruth truth = world.Truth(0.01);
  size_t chosen = 0;  // the middle of a side
  for (size_t i = 0; i < truth.points.size(); ++i) {
    const Vec3f middle(-0.2f, 0.0f, 0.5f);
    if ((truth.points[i] - middle).norm() < (truth.points[chosen] - middle).norm()) chosen = i;
  }
  AttainableOptions options;
  options.lattice_m = 1.0;
  const auto [sum, most] = ExpectedRays(world, truth.points[chosen], truth.normals[chosen], options);
  ASSERT_GT(0.8 * sum, 1.5 * most) << "no position alone suffices";
  const auto attainable = [&](double min_rays) {
    options.min_rays = min_rays;
    return ComputeAttainable(world.scene, truth, TestRobot(), core::FindLidarModel("vlp16"), options,
                             world.Caster(), nullptr)
        .attainable[chosen];
  };
  EXPECT_TRUE(attainable(0.8 * sum));
  EXPECT_FALSE(attainable(1.25 * sum));
}

/// A tower in a yard: the robot cannot back away, so only a rolled sensor sees how high it is.
BoxWorld TowerInAYard() {
  BoxWorld world;
  world.Add({-2.2, -2.2, -0.5}, {2.2, 2.2, 0});
  world.Add({-0.3, -0.3, 0}, {0.3, 0.3, 4.0}, true);
  world.Add({-2.3, -2.3, 0}, {-2.2, 2.3, 5.0});
  world.Add({2.2, -2.3, 0}, {2.3, 2.3, 5.0});
  world.Add({-2.2, -2.3, 0}, {2.2, -2.2, 5.0});
  world.Add({-2.2, 2.2, 0}, {2.2, 2.3, 5.0});
  world.scene.T_map_spawn = core::PoseFromXyzYaw({-1.3, 0.0, 0.0}, 0.0);
  return world;
}

TEST(Attainable, AYardShowsAsMuchOfItsTowerAsTheRollLets) {
  const BoxWorld world = TowerInAYard();
  const scenes::GroundTruth truth = world.Truth(0.02);
  const auto highest = [&](double roll_deg, const std::string& lidar) {
    AttainableOptions options;
    options.sweep_roll_deg = roll_deg;
    options.lattice_m = 0.3;
    const Attainable set = ComputeAttainable(world.scene, truth, TestRobot(), core::FindLidarModel(lidar),
                                             options, world.Caster(), nullptr);
    float top = 0.0f;
    for (size_t i = 0; i < truth.points.size(); ++i) {
      if (set.attainable[i] != 0) top = std::max(top, truth.points[i].z());
    }
    return top;
  };
  // Level, a VLP-16 looks 15 degrees up; from at most 2.5 m away that is 0.7 m above the sensor.
  const float level = highest(0.0, "vlp16"), rolled = highest(20.0, "vlp16"), far = highest(40.0, "vlp16");
  EXPECT_LT(level, 1.6f);
  EXPECT_GT(rolled, level + 0.4f);
  EXPECT_GT(far, rolled + 0.4f);
  EXPECT_GT(highest(0.0, "os0_64"), level + 0.4f);  // looks 45 degrees up
}

TEST(Attainable, DoesNotDependOnTheNumberOfThreads) {
  const BoxWorld world = SmallWorld();
  const scenes::GroundTruth truth = world.Truth(0.02);
  AttainableOptions options;
  const auto with = [&](int threads) {
    options.threads = threads;
    return ComputeAttainable(world.scene, truth, TestRobot(), TestLidar(), options, world.Caster(), nullptr);
  };
  const Attainable one = with(1), three = with(3);
  EXPECT_EQ(one.attainable, three.attainable);
  EXPECT_EQ(one.rays, three.rays);
}

TEST(Attainable, OfARunIsThatOfItsOwnSensorSweepsAndScore) {
  ExperimentConfig config;
  config.mission.coverage_radius_m = 0.11;
  config.mapper.integrator.max_range_m = 12.5;
  config.sim.locomotion.sweep_roll_deg = 33.0;
  config.sim.locomotion.sweep_period_s = 4.5;
  const AttainableOptions options = AttainableOptionsFor(config, 3);
  EXPECT_EQ(options.radius_m, 0.11);
  EXPECT_EQ(options.max_range_m, 12.5);
  EXPECT_EQ(options.sweep_roll_deg, 33.0);
  EXPECT_EQ(options.sweep_period_s, 4.5);
  EXPECT_EQ(options.threads, 3);
}

}  // namespace
}  // namespace atlas::experiments
