// LiDAR odometry in front of localisers, in a hall whose rays are closed forms.
#include "mapping/slam/lidar_front_end.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/se3.h"
#include "tests/support/analytic_world.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Mat6;
using core::Pose;
using core::Vec3;

AnalyticWorld HallWithCupboards() {
  AnalyticWorld world;
  world.AddBox({{-5.0, -3.5, 0.0}, {5.0, 3.5, 2.7}});
  world.AddBox({{-4.9, 2.5, 0.0}, {-3.5, 3.5, 2.0}});
  world.AddBox({{2.5, -3.5, 0.0}, {3.9, -2.5, 1.4}});
  world.AddPillar(0.0, 0.3, 0.25, 0.0, 2.7);
  return world;
}

const Pose kT_base_lidar = core::PoseFromXyzYaw({0.2, 0.0, 0.3}, 0.0);

Pose RoundAt(double time_s) {
  const double phase = 0.35 * time_s;
  return core::PoseFromXyzYaw(Vec3(2.4 * std::cos(phase), 1.8 * std::sin(phase), 0.6), phase + 1.57);
}

/// Walks round a pillar with a prior that is 4 % too long and turns by 1 degree a metre.
struct PriorWalk {
  PriorWalk(const LocalisationParams& params, bool matched, double until_s) {
    const Pose start = RoundAt(0.0);
    const LocaliserStart from{.T_map_odom = start, .T_odom_base = Pose::Identity(), .T_map_base_true = {}};
    localiser = matched ? PutLidarOdometryBefore(params, from, core::Rng(1))
                        : MakeLocaliser(params, from, core::Rng(1));
    core::LidarModel lidar = core::FindLidarModel("os0_64");
    lidar.columns = 360;
    Pose T_prior_base = Pose::Identity(), T_before = start;
    core::PoseTrajectory T_map_lidar, T_prior_lidar;
    for (int k = 0; 0.02 * k < until_s; ++k) {
      const double time_s = 0.02 * k;
      const Pose T_now = RoundAt(time_s);
      Pose step = T_before.inverse() * T_now;
      const double way_m = step.translation().norm();
      step.translation() *= 1.04;
      step.linear() = step.linear() * core::RotationFromYawPitchRoll(core::Radians(1.0) * way_m, 0.0, 0.0);
      T_prior_base = T_prior_base * step;
      T_before = T_now;
      T_map_lidar.Add(time_s, T_now * kT_base_lidar);
      T_prior_lidar.Add(time_s, T_prior_base * kT_base_lidar);
      core::StateEvent state;
      state.time_s = time_s;
      state.T_odom_base = T_prior_base;
      localiser->OnState(state);
      if (k % 10 != 5 || k < 10) continue;
      auto spin = std::make_shared<core::SpinEvent>(
          SpinThrough(HallWithCupboards(), lidar, time_s - 0.1, T_map_lidar));
      spin->T_odom_lidar = T_prior_lidar;
      const core::AnchoredSpin placed = localiser->Place(spin);
      EXPECT_EQ(placed.spin, spin);
      EXPECT_LT((placed.T_map_odom(*localiser->poses()).matrix() - localiser->T_map_odom().matrix()).norm(),
                1e-9)
          << "one frame for the revolution and for whoever walks";
    }
    error_m = ((localiser->T_map_odom() * T_prior_base).translation() - T_before.translation()).norm();
    prior_error_m = ((start * T_prior_base).translation() - T_before.translation()).norm();
  }
  std::unique_ptr<Localiser> localiser;
  double error_m = 0.0, prior_error_m = 0.0;
};

TEST(LidarFrontEnd, CorrectsThePriorForEachLocaliser) {
  for (const char* name : {"none", "slam"}) {
    LocalisationParams params;
    params.name = name;
    params.slam.loop_tries = 0;
    const PriorWalk walk(params, true, 10.0), without(params, false, 10.0);
    ASSERT_GT(walk.prior_error_m, 0.25);
    EXPECT_LT(walk.error_m, 0.03) << name;
    EXPECT_NEAR(without.error_m, walk.prior_error_m, 1e-9) << name;
    ASSERT_TRUE(walk.localiser->odometry_health());
    EXPECT_FALSE(without.localiser->odometry_health());
    EXPECT_EQ(walk.localiser->odometry_health()->revolutions, 49u);
    EXPECT_EQ(walk.localiser->odometry_health()->lost, 0u);
    EXPECT_EQ(walk.localiser->odometry_health()->degenerate, 0u);
  }
}

TEST(LidarFrontEnd, AddsCovariancesInTheFrameAtTheEnd) {
  // Monte Carlo's answer in closed form: steps of 1 m ahead, each with a yaw error of sigma, then a turn.
  MotionCovariance motion;
  const double sigma_rad = 0.01, sigma_m = 0.001;
  Mat6 information = Mat6::Identity() / (sigma_m * sigma_m);
  information.bottomRightCorner<3, 3>() = core::Mat3::Identity() / (sigma_rad * sigma_rad);
  const Pose step = core::PoseFromXyzYaw({1.0, 0.0, 0.0}, 0.0);
  for (int k = 0; k < 3; ++k) motion.Add(step, information);
  const Mat6 covariance = motion.Take(Pose::Identity(), 3.0, 1e-6, 1e-6);
  // Errors after the first and second step swing what follows, 2 m and 1 m.
  EXPECT_NEAR(covariance(1, 1), 3 * sigma_m * sigma_m + (4.0 + 1.0) * sigma_rad * sigma_rad, 1e-7);
  EXPECT_NEAR(covariance(0, 0), 3 * sigma_m * sigma_m, 1e-7);
  EXPECT_NEAR(covariance(5, 5), 3 * sigma_rad * sigma_rad, 1e-7);
  EXPECT_TRUE(
      motion.Take(Pose::Identity(), 2.0, 0.01, 0.1).diagonal().head<3>().isApproxToConstant(1e-4, 1e-9))
      << "begun anew, at its floor";
}

TEST(LidarFrontEnd, NothingKnownMovesNothing) {
  MotionCovariance motion;
  motion.Add(core::PoseFromXyzYaw({1.0, 0.0, 0.0}, 0.0), Mat6::Zero());
  EXPECT_TRUE(motion.Take(Pose::Identity(), 2.0, 0.01, 0.1).allFinite());
}

}  // namespace
}  // namespace atlas::tests
