// What odometry errs by, against the statistics that its parameters state.
#include "sim/walking/odometry.h"

#include <gtest/gtest.h>

#include <cmath>

namespace atlas::sim {
namespace {

using core::Pose;
using core::Vec3;

OdometryParams Perfect() {
  OdometryParams params;
  params.drift_xy_per_m = params.drift_yaw_deg_per_m = 0.0;
  return params;
}

/// Walks along x at 1 m/s from x = `from`; `each` sees the truth after every update.
template <typename Each>
void Walk(Odometry* odometry, double from, double seconds, const Each& each) {
  for (int step = 1; step <= static_cast<int>(100.0 * seconds); ++step) {
    const Pose T = core::PoseFromXyzYaw({from + 0.01 * step, 0.0, 0.4}, 0.0);
    odometry->Update(T);
    each(T);
  }
}

TEST(Odometry, PositionDriftsByItsRandomWalk) {
  OdometryParams params = Perfect();
  params.drift_xy_per_m = 0.1;
  double squared = 0.0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Odometry odometry(params, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0),
                      core::Rng(static_cast<uint64_t>(run)));
    Walk(&odometry, 0.0, 4.0, [](const Pose&) {});
    squared += (odometry.T_odom_base().translation() - Vec3(4.0, 0.0, 0.4)).squaredNorm();
  }
  EXPECT_NEAR(squared / kRuns, 2.0 * 0.01 * 4.0, 0.25 * 0.08);
}

TEST(Odometry, HeadingDriftsByItsRandomWalkInDegrees) {
  OdometryParams params = Perfect();
  params.drift_yaw_deg_per_m = 1.5;
  double squared = 0.0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Odometry odometry(params, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0),
                      core::Rng(static_cast<uint64_t>(run)));
    Walk(&odometry, 0.0, 4.0, [](const Pose&) {});
    const double yaw_deg = core::Degrees(core::YawOf(odometry.T_odom_base().linear()));
    squared += yaw_deg * yaw_deg;
  }
  EXPECT_NEAR(std::sqrt(squared / kRuns), 1.5 * 2.0, 0.15 * 3.0);
}

TEST(Odometry, HeadingErrorsHappenWhereTheRobotIs) {
  OdometryParams params = Perfect();
  params.drift_yaw_deg_per_m = 5.0;
  Odometry odometry(params, Pose::Identity(), core::PoseFromXyzYaw({100.0, 0.0, 0.4}, 0.0), core::Rng(9));
  double turned = 0.0, moved = 0.0;
  Walk(&odometry, 100.0, 1.0, [&](const Pose& T) {
    turned = std::max(turned, std::abs(core::YawOf(odometry.T_odom_base().linear())));
    moved = std::max(moved, (odometry.T_odom_base().translation() - T.translation()).norm());
  });
  EXPECT_GT(turned, core::Radians(1.0));
  EXPECT_LT(moved, 0.5) << "about the origin, a degree would move it by 1.7 m";
}

TEST(Odometry, ThatWandersIsAMetreOffAfterAHundred) {
  // 2 cm and 0.1 degrees an axis every 2 m, composed edge by edge: 1.03 m (root mean square).
  OdometryParams params;
  params.name = "drift";
  double squared = 0.0, height_squared = 0.0;
  constexpr int kRuns = 300;
  for (int run = 0; run < kRuns; ++run) {
    Odometry odometry(params, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0),
                      core::Rng(static_cast<uint64_t>(run)));
    Walk(&odometry, 0.0, 100.0, [](const Pose&) {});
    const Vec3 error = odometry.T_odom_base().translation() - Vec3(100.0, 0.0, 0.4);
    squared += error.squaredNorm();
    height_squared += error.z() * error.z();
  }
  EXPECT_NEAR(std::sqrt(squared / kRuns), 1.03, 0.12);
  EXPECT_NEAR(height_squared / squared, 0.5, 0.12) << "it wanders up and down as well";
}

TEST(Odometry, ThatIsBiasedErrsInProportionToTheWay) {
  OdometryParams params;
  params.name = "drift";
  params.drift_scale = 1.0;
  params.drift_bias = 0.5;
  Vec3 squared = Vec3::Zero();
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    OdometryParams unbiased = params;
    unbiased.drift_bias = 0.0;
    const core::Rng rng(static_cast<uint64_t>(run));
    const Pose start = core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0);
    Odometry odometry(params, Pose::Identity(), start, rng), without(unbiased, Pose::Identity(), start, rng);
    Walk(&odometry, 0.0, 4.0, [](const Pose&) {});
    Walk(&without, 0.0, 4.0, [](const Pose&) {});
    squared += (odometry.T_odom_base().translation() - without.T_odom_base().translation()).cwiseAbs2();
  }
  EXPECT_NEAR(std::sqrt(squared.x() / kRuns), 0.5 * 0.02 / 2.0 * 4.0, 0.004)
      << "along the way, 1 cm a metre, halved";
}

TEST(Odometry, ThatIsTheTruthHasNoError) {
  OdometryParams params;
  params.name = "truth";
  Odometry odometry(params, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0), core::Rng(1));
  Walk(&odometry, 0.0, 5.0,
       [&](const Pose& T) { EXPECT_LT((odometry.T_odom_base().matrix() - T.matrix()).norm(), 1e-12); });
}

TEST(Odometry, APriorOfScanMatchingIsTooLongAndTurns) {
  OdometryParams params;
  params.name = "lidar";
  params.prior_bias = 0.02;
  params.prior_bias_deg_per_m = 0.5;
  params.prior_xy_per_m = params.prior_yaw_deg_per_m = 0.0;
  Odometry odometry(params, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0), core::Rng(3));
  Walk(&odometry, 0.0, 20.0, [](const Pose&) {});
  // A circle of 1.02 m a metre, with 0.5 degrees a metre.
  const double turn = core::Radians(0.5) * 20.0, radius_m = 1.02 / core::Radians(0.5);
  const Vec3 expected(radius_m * std::sin(turn), radius_m * (1.0 - std::cos(turn)), 0.4);
  EXPECT_LT((odometry.T_odom_base().translation() - expected).norm(), 0.02);
  EXPECT_NEAR(core::YawOf(odometry.T_odom_base().linear()), turn, 1e-3);
  EXPECT_NEAR(odometry.T_odom_base().translation().z(), 0.4, 1e-9) << "height is observable";
}

TEST(Odometry, StartsAtTheSpawnPose) {
  const Pose T_map_spawn = core::PoseFromXyzYaw({2.0, -1.0, 0.0}, 0.8);
  const Odometry odometry(Perfect(), T_map_spawn, T_map_spawn * core::PoseFromXyzYaw({0.0, 0.0, 0.44}, 0.0),
                          core::Rng(1));
  EXPECT_LT((odometry.T_odom_base().translation() - Vec3(0.0, 0.0, 0.44)).norm(), 1e-9);
}

}  // namespace
}  // namespace atlas::sim
