// LiDAR odometry against worlds whose rays are closed forms: where the LiDAR was is known exactly.
#include "mapping/slam/lidar_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>

#include "core/se3.h"
#include "tests/support/analytic_world.h"

namespace atlas::tests {
namespace {

using core::Pose;
using core::PoseTrajectory;
using core::Vec3;
using mapping::LidarOdometry;
using mapping::LidarOdometryResult;

constexpr double kPeriod_s = 0.1;

core::LidarModel CoarseLidar() {
  core::LidarModel lidar = core::FindLidarModel("os0_64");
  lidar.columns = 512;
  return lidar;
}

/// 10 x 7 m with cupboards, a table and a pillar.
AnalyticWorld FurnishedHall() {
  AnalyticWorld world;
  world.AddBox({{-5.0, -3.5, 0.0}, {5.0, 3.5, 2.7}});
  world.AddBox({{-4.9, 2.5, 0.0}, {-3.5, 3.5, 2.0}});
  world.AddBox({{2.5, -3.5, 0.0}, {3.9, -2.5, 1.4}});
  world.AddBox({{0.2, 2.7, 0.0}, {1.6, 3.5, 1.9}});
  world.AddBox({{-2.2, -1.4, 0.5}, {-1.0, -0.4, 0.8}});
  world.AddPillar(1.4, 0.8, 0.25, 0.0, 2.7);
  return world;
}

/// 40 m of bare walls: nothing tells how far along it is.
AnalyticWorld BareCorridor() {
  AnalyticWorld world;
  world.AddPlane(Vec3::UnitY(), 0.8);
  world.AddPlane(Vec3::UnitY(), -0.8);
  world.AddPlane(Vec3::UnitZ(), 0.0);
  world.AddPlane(Vec3::UnitZ(), 2.4);
  return world;
}

using Way = std::function<Pose(double time_s)>;

/// An ellipse walked at about 0.8 m/s, nodding and swaying as a walker does.
Pose WalkedAt(double time_s) {
  const double phase = 0.4 * time_s, step = 2.0 * core::kPi * 1.4 * time_s;
  const Vec3 p(2.6 * std::cos(phase) - 0.3, 1.7 * std::sin(phase), 1.0 + 0.015 * std::sin(step));
  const double yaw = phase + 0.5 * core::kPi + core::Radians(2.5) * std::sin(0.5 * step);
  return core::MakePose(core::RotationFromYawPitchRoll(yaw, core::Radians(1.5) * std::sin(step),
                                                       core::Radians(2.0) * std::cos(0.5 * step)),
                        p);
}

Pose AlongCorridorAt(double time_s) {
  return core::PoseFromXyzYaw(Vec3(0.7 * time_s, 0.1 * std::sin(time_s), 1.0), 0.2 * std::sin(0.8 * time_s));
}

PoseTrajectory During(const Way& way, double start_s) {
  PoseTrajectory poses;
  for (int k = -1; k <= 26; ++k) poses.Add(start_s + 0.004 * k, way(start_s + 0.004 * k));
  return poses;
}

core::SpinEvent SpinOf(const AnalyticWorld& world, const Way& way, int index) {
  core::Rng noise(static_cast<uint64_t>(100 + index));
  return SpinThrough(world, CoarseLidar(), kPeriod_s * index, During(way, kPeriod_s * index), &noise);
}

/// What legs and a gyroscope make of a way: 3 % too long, and 0.6 degrees a second of yaw.
class BiasedWay {
 public:
  BiasedWay(const Way& truth, double until_s) {
    Pose T = truth(kFrom_s);
    for (double t = kFrom_s; t < until_s; t += kStep_s) {
      poses_.Add(t, T);
      Pose step = truth(t).inverse() * truth(t + kStep_s);
      step.translation() *= 1.03;
      step.linear() = step.linear() * core::RotationFromYawPitchRoll(core::Radians(0.6) * kStep_s, 0.0, 0.0);
      T = T * step;
    }
  }
  Pose operator()(double time_s) const { return poses_.At(time_s); }

 private:
  static constexpr double kFrom_s = -0.01, kStep_s = 0.002;
  PoseTrajectory poses_;
};

struct Tracked {
  std::vector<LidarOdometryResult> results;
  std::vector<Pose> truth, prior;  ///< at the results' times

  Pose Error() const {
    const Pose moved = truth.front().inverse() * truth.back();
    return moved.inverse() * (results.front().T_odom_lidar.inverse() * results.back().T_odom_lidar);
  }
  double PriorError() const {
    const Pose moved = truth.front().inverse() * truth.back();
    return (moved.inverse() * (prior.front().inverse() * prior.back())).translation().norm();
  }
  double WorstError() const {
    double worst = 0.0;
    for (size_t i = 0; i < truth.size(); ++i) {
      const Pose moved = truth.front().inverse() * truth[i];
      const Pose found = results.front().T_odom_lidar.inverse() * results[i].T_odom_lidar;
      worst = std::max(worst, (moved.inverse() * found).translation().norm());
    }
    return worst;
  }
};

double TurnDeg(const Pose& T) {
  return core::Degrees(Eigen::AngleAxisd(T.linear()).angle());
}

enum class Prior { kBiased, kNone, kGyro };

Tracked Track(const AnalyticWorld& world, const Way& way, int scans, Prior prior, int threads = 1) {
  mapping::LidarOdometryParams params;
  params.threads = threads;
  LidarOdometry odometry(params);
  const Way biased = BiasedWay(way, kPeriod_s * (scans + 2));
  Tracked tracked;
  for (int k = 0; k < scans; ++k) {
    core::SpinEvent spin = SpinOf(world, way, k);
    const PoseTrajectory told = During(biased, spin.scan.stamp_s);
    if (prior == Prior::kBiased) {
      spin.T_odom_lidar = told;
      tracked.results.push_back(odometry.Add(spin));
    } else if (prior == Prior::kGyro) {
      tracked.results.push_back(odometry.Add(spin.scan, told));
    } else {
      tracked.results.push_back(odometry.Add(spin.scan));
    }
    const double time_s = tracked.results.back().time_s;
    tracked.truth.push_back(During(way, kPeriod_s * k).At(time_s));
    tracked.prior.push_back(told.At(time_s));
  }
  return tracked;
}

TEST(LidarOdometry, CorrectsABiasedPrior) {
  const Tracked tracked = Track(FurnishedHall(), WalkedAt, 120, Prior::kBiased);
  ASSERT_GT(tracked.PriorError(), 0.15);
  EXPECT_LT(tracked.WorstError(), 0.02) << "of 10 m";
  EXPECT_LT(TurnDeg(tracked.Error()), 0.15);
  for (size_t k = 1; k < tracked.results.size(); ++k) {
    EXPECT_TRUE(tracked.results[k].tracked) << k;
    EXPECT_FALSE(tracked.results[k].degenerate) << k;
    EXPECT_GT(tracked.results[k].overlap, 0.7) << k;
  }
}

TEST(LidarOdometry, ThePriorsFrameTakesTheCorrection) {
  const Tracked tracked = Track(FurnishedHall(), WalkedAt, 20, Prior::kBiased);
  const LidarOdometryResult& last = tracked.results.back();
  EXPECT_TRUE((last.T_odom_prior * tracked.prior.back()).matrix().isApprox(last.T_odom_lidar.matrix(), 1e-9));
  // What a revolution corrects is millimetres.
  const Pose start = last.trajectory.poses().front().T;
  const LidarOdometryResult& before = tracked.results[tracked.results.size() - 2];
  EXPECT_LT((before.T_odom_lidar.inverse() * start).translation().norm(), 0.006);
}

TEST(LidarOdometry, NeedsNoPrior) {
  const Tracked tracked = Track(FurnishedHall(), WalkedAt, 120, Prior::kNone);
  EXPECT_LT(tracked.Error().translation().norm(), 0.05);
  EXPECT_LT(TurnDeg(tracked.Error()), 0.5);
}

TEST(LidarOdometry, AGyroscopeAloneIsAPrior) {
  const Tracked with = Track(FurnishedHall(), WalkedAt, 120, Prior::kGyro);
  EXPECT_LT(with.WorstError(), 0.03);
  EXPECT_LT(TurnDeg(with.Error()), 0.15);
}

TEST(LidarOdometry, UndistortsFastTurns) {
  // 120 degrees a second: without undistortion ends of a revolution part by 12 degrees.
  const Way turning = [](double time_s) {
    return core::PoseFromXyzYaw(Vec3(0.3 * std::sin(time_s), 0.2, 1.0), core::Radians(120.0) * time_s);
  };
  const Tracked tracked = Track(FurnishedHall(), turning, 40, Prior::kNone);
  EXPECT_LT(TurnDeg(tracked.Error()), 0.5);
  EXPECT_LT(tracked.Error().translation().norm(), 0.03);
}

TEST(LidarOdometry, ABareCorridorIsDegenerateAndKeepsThePriorAlongIt) {
  const Tracked tracked = Track(BareCorridor(), AlongCorridorAt, 80, Prior::kBiased);
  const Pose T_world_odom = tracked.truth.front() * tracked.results.front().T_odom_lidar.inverse();
  for (size_t k = 1; k < tracked.results.size(); ++k) {
    const LidarOdometryResult& result = tracked.results[k];
    ASSERT_TRUE(result.degenerate) << k;
    EXPECT_GT(std::abs((T_world_odom.linear() * result.weak_direction_odom).x()), 0.99) << k;
    // The information knows it: along the corridor that of the prior alone, across it centimetres at most.
    const mapping::Matrix6 covariance = result.information.inverse();
    const core::Mat3 R = T_world_odom.linear() * result.T_odom_lidar.linear();
    const core::Mat3 in_world = R * covariance.topLeftCorner<3, 3>() * R.transpose();
    EXPECT_NEAR(std::sqrt(in_world(0, 0)), 0.05, 0.01) << k;
    EXPECT_LT(std::sqrt(in_world(1, 1)), 0.01) << k;
  }
  const Vec3 found = T_world_odom * tracked.results.back().T_odom_lidar.translation();
  const Vec3 truth = tracked.truth.back().translation();
  const double way_m = truth.x() - tracked.truth.front().translation().x();
  EXPECT_NEAR((found.x() - truth.x()) / way_m, 0.03, 0.01) << "the prior's 3 % too long";
  EXPECT_NEAR(found.y(), truth.y(), 0.02);
  EXPECT_NEAR(found.z(), truth.z(), 0.02);
}

TEST(LidarOdometry, AJumpIsFoundAgain) {
  const Way jumping = [](double time_s) {
    return core::PoseFromXyzYaw(Vec3(time_s < 0.95 ? -1.2 : 0.6, 0.4, 1.0), time_s < 0.95 ? 0.0 : 0.5);
  };
  LidarOdometry odometry({});
  LidarOdometryResult first, last;
  for (int k = 0; k < 15; ++k) {
    const Pose T = jumping(kPeriod_s * k);
    core::Rng noise(static_cast<uint64_t>(100 + k));
    const core::SpinEvent spin =
        SpinThrough(FurnishedHall(), CoarseLidar(), kPeriod_s * k, StandingAt(T), &noise);
    last = odometry.Add(spin.scan);
    if (k == 0) first = last;
  }
  const Pose moved = jumping(0.0).inverse() * jumping(1.4);
  const Pose error = moved.inverse() * (first.T_odom_lidar.inverse() * last.T_odom_lidar);
  EXPECT_LT(error.translation().norm(), 0.03);
  EXPECT_LT(TurnDeg(error), 0.5);
}

TEST(LidarOdometry, AnotherWorldIsNotTracked) {
  LidarOdometry odometry({});
  for (int k = 0; k < 3; ++k) odometry.Add(SpinOf(FurnishedHall(), WalkedAt, k));
  AnalyticWorld elsewhere;
  elsewhere.AddPlane(Vec3::UnitZ(), -6.0);
  elsewhere.AddSphere(Vec3(9.0, 14.0, 0.0), 4.0);
  const LidarOdometryResult lost = odometry.Add(SpinOf(elsewhere, WalkedAt, 3));
  EXPECT_FALSE(lost.tracked);
  const Pose step = During(WalkedAt, 0.2).At(0.3).inverse() * During(WalkedAt, 0.3).At(lost.time_s);
  EXPECT_TRUE(lost.T_odom_lidar.matrix().allFinite());
  EXPECT_LT(step.translation().norm(), 0.2);
}

TEST(LidarOdometry, AScanWithoutReturnsKeepsThePrior) {
  LidarOdometry odometry({});
  core::SpinEvent spin = SpinOf(FurnishedHall(), WalkedAt, 0);
  odometry.Add(spin);
  core::SpinEvent empty = SpinOf(FurnishedHall(), WalkedAt, 1);
  for (auto& kind : empty.scan.kind) kind = core::ReturnKind::kVoid;
  const LidarOdometryResult result = odometry.Add(empty);
  EXPECT_FALSE(result.tracked);
  EXPECT_TRUE(result.T_odom_lidar.matrix().isApprox(empty.T_odom_lidar.At(result.time_s).matrix(), 1e-6));
}

TEST(LidarOdometry, ThreadsChangeNoByte) {
  std::vector<Eigen::Matrix4d> ends;
  for (const int threads : {1, 3})
    ends.push_back(
        Track(FurnishedHall(), WalkedAt, 12, Prior::kNone, threads).results.back().T_odom_lidar.matrix());
  EXPECT_EQ(std::memcmp(ends[0].data(), ends[1].data(), sizeof(double) * 16), 0);
}

}  // namespace
}  // namespace atlas::tests
