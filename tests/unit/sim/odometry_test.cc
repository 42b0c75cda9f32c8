// What localisation and odometry err by, against the statistics that their parameters state.
#include "sim/odometry.h"

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

const LocalisationParams kExact{.name = "truth", .sigma_m = 0.0, .sigma_deg = 0.0, .period_s = 1.0};

Pose Believed(const Odometry& odometry) {
  return odometry.T_map_odom() * odometry.T_odom_base();
}

TEST(Odometry, LocalisationErrsByItsSigmasOnEveryAxis) {
  const LocalisationParams noisy{.name = "truth", .sigma_m = 0.03, .sigma_deg = 0.5, .period_s = 1.0};
  const Pose T = core::MakePose(core::RotationFromYawPitchRoll(0.7, 0.1, -0.2), Vec3(3.0, -2.0, 0.5));
  Odometry odometry(Perfect(), noisy, core::PoseFromXyzYaw({1.0, 1.0, 0.0}, 0.3), T, core::Rng(3));
  Vec3 shift2 = Vec3::Zero(), turn2 = Vec3::Zero();
  constexpr int kDraws = 4000;
  for (int second = 1; second <= kDraws; ++second) {
    odometry.Update(second, T);
    const Pose believed = Believed(odometry);
    shift2 += (believed.translation() - T.translation()).cwiseAbs2();
    const Eigen::AngleAxisd turn(core::Mat3(believed.linear() * T.linear().transpose()));
    turn2 += (turn.angle() * turn.axis()).cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(std::sqrt(shift2[axis] / kDraws), 0.03, 0.05 * 0.03) << axis;
    EXPECT_NEAR(core::Degrees(std::sqrt(turn2[axis] / kDraws)), 0.5, 0.05 * 0.5) << axis;
  }
}

/// Walks along x at 1 m/s from x = `from`; `each` sees time and truth after every update.
template <typename Each>
void Walk(Odometry* odometry, double from, double seconds, const Each& each) {
  for (int step = 1; step <= static_cast<int>(100.0 * seconds); ++step) {
    const Pose T = core::PoseFromXyzYaw({from + 0.01 * step, 0.0, 0.4}, 0.0);
    odometry->Update(0.01 * step, T);
    each(step, T);
  }
}

TEST(Odometry, IsLocalisedOnceASecondAndDriftsInBetween) {
  OdometryParams params = Perfect();
  params.drift_xy_per_m = 0.1;
  Odometry odometry(params, kExact, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0),
                    core::Rng(5));
  double before2 = 0.0, worst_after = 0.0;
  constexpr int kSeconds = 300;
  Walk(&odometry, 0.0, kSeconds, [&](int step, const Pose& T) {
    const double error = (Believed(odometry).translation() - T.translation()).norm();
    if (step % 100 == 99) before2 += error * error;
    if (step % 100 == 0) worst_after = std::max(worst_after, error);
  });
  EXPECT_LT(worst_after, 1e-9);
  // Two axes of 0.1 a metre, over 0.99 m; of 600 squared normals the mean errs by 6 %.
  EXPECT_NEAR(before2 / kSeconds, 2.0 * 0.01 * 0.99, 0.2 * 0.02);
}

TEST(Odometry, WithoutLocalisationDriftIsNeverTakenBack) {
  OdometryParams params = Perfect();
  params.drift_xy_per_m = 0.1;
  LocalisationParams none;
  none.name = "none";
  double squared = 0.0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Odometry odometry(params, none, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0),
                      core::Rng(static_cast<uint64_t>(run)));
    Walk(&odometry, 0.0, 4.0, [](int, const Pose&) {});
    squared += (Believed(odometry).translation() - Vec3(4.0, 0.0, 0.4)).squaredNorm();
    EXPECT_EQ(odometry.T_map_odom().matrix(), Pose::Identity().matrix());
  }
  EXPECT_NEAR(squared / kRuns, 2.0 * 0.01 * 4.0, 0.25 * 0.08);
}

TEST(Odometry, HeadingDriftsByItsRandomWalkInDegrees) {
  OdometryParams params = Perfect();
  params.drift_yaw_deg_per_m = 1.5;
  double squared = 0.0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Odometry odometry(params, kExact, Pose::Identity(), core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0),
                      core::Rng(static_cast<uint64_t>(run)));
    Walk(&odometry, 0.0, 4.0, [](int, const Pose&) {});
    const double yaw_deg = core::Degrees(core::YawOf(odometry.T_odom_base().linear()));
    squared += yaw_deg * yaw_deg;
  }
  EXPECT_NEAR(std::sqrt(squared / kRuns), 1.5 * 2.0, 0.15 * 3.0);
}

TEST(Odometry, HeadingErrorsHappenWhereTheRobotIs) {
  OdometryParams params = Perfect();
  params.drift_yaw_deg_per_m = 5.0;
  Odometry odometry(params, kExact, Pose::Identity(), core::PoseFromXyzYaw({100.0, 0.0, 0.4}, 0.0),
                    core::Rng(9));
  double turned = 0.0, moved = 0.0;
  Walk(&odometry, 100.0, 1.0, [&](int, const Pose& T) {
    turned = std::max(turned, std::abs(core::YawOf(odometry.T_odom_base().linear())));
    moved = std::max(moved, (odometry.T_odom_base().translation() - T.translation()).norm());
  });
  EXPECT_GT(turned, core::Radians(1.0));
  EXPECT_LT(moved, 0.5) << "about the origin, a degree would move it by 1.7 m";
}

TEST(Odometry, StartsAtTheSpawnPose) {
  const Pose T_map_spawn = core::PoseFromXyzYaw({2.0, -1.0, 0.0}, 0.8);
  const Odometry odometry(Perfect(), kExact, T_map_spawn,
                          T_map_spawn * core::PoseFromXyzYaw({0.0, 0.0, 0.44}, 0.0), core::Rng(1));
  EXPECT_LT((odometry.T_odom_base().translation() - Vec3(0.0, 0.0, 0.44)).norm(), 1e-9);
  EXPECT_LT((odometry.T_map_odom().matrix() - T_map_spawn.matrix()).norm(), 1e-9);
}

TEST(Odometry, WithoutLocalisationTheCorrectionStaysWhatItWasAtTheStart) {
  OdometryParams params = Perfect();
  params.drift_xy_per_m = 0.1;
  const Pose T_map_spawn = core::PoseFromXyzYaw({2.0, -1.0, 0.0}, 0.8);
  const Pose start = core::PoseFromXyzYaw({0.0, 0.0, 0.4}, 0.0);
  Odometry odometry(params, {.name = "none", .sigma_m = 0.1, .sigma_deg = 1.0, .period_s = 0.0}, T_map_spawn,
                    start, core::Rng(5));
  EXPECT_LT((Believed(odometry).matrix() - start.matrix()).norm(), 1e-9) << "the start is known";
  double error = 0.0;
  Walk(&odometry, 0.0, 100.0, [&](int, const Pose& T) {
    EXPECT_EQ(odometry.T_map_odom().matrix(), T_map_spawn.matrix());
    error = (Believed(odometry).translation() - T.translation()).norm();
  });
  EXPECT_GT(error, 0.1) << "100 m of a random walk of 0.1 a metre";
}

}  // namespace
}  // namespace atlas::sim
