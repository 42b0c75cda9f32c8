#include "sim/sensors/lidar.h"

#include <gtest/gtest.h>

#include "tests/support/sensor_scenes.h"

namespace atlas::sim {
namespace {

using namespace testing;  // NOLINT
using core::ReturnKind;

/// A VLP-16 whose returns are exact.
core::LidarModel ExactLidar() {
  core::LidarModel model = core::FindLidarModel("vlp16");
  model.range_sigma_m = 0.0;
  model.dropout_probability = 0.0;
  return model;
}

core::PoseTrajectory Still(const core::Pose& T = core::Pose::Identity()) {
  core::PoseTrajectory trajectory;
  trajectory.Add(0.0, T);
  return trajectory;
}

size_t Count(const core::LidarScan& scan, ReturnKind kind) {
  return static_cast<size_t>(std::count(scan.kind.begin(), scan.kind.end(), kind));
}

TEST(LidarTest, ColumnsFireEvenlyOverTheRevolution) {
  Raycaster nothing{scenes::SceneSpec{}};
  const core::LidarModel model = ExactLidar();
  const core::LidarScan scan = Lidar(model, core::Rng(1)).Spin(&nothing, 5.0, Still(), nullptr, 1);
  ASSERT_EQ(scan.size(), static_cast<size_t>(16 * 1800));
  EXPECT_EQ(scan.stamp_s, 5.0);
  for (int row = 0; row < scan.rows; ++row) {
    for (int column = 0; column < scan.columns; column += 7) {
      const auto i = static_cast<size_t>(row * scan.columns + column);
      EXPECT_NEAR(scan.time_s[i], 0.1 * column / 1800.0, 1e-7);
      const core::Vec3f& d = scan.direction_lidar[i];
      EXPECT_NEAR(d.norm(), 1.0f, 1e-6);
      EXPECT_NEAR(core::WrapAngle(std::atan2(d.y(), d.x()) + 2.0 * core::kPi * column / 1800.0), 0.0, 1e-5);
      EXPECT_NEAR(std::asin(d.z()), model.elevation_rad[static_cast<size_t>(row)], 1e-6);
    }
  }
}

TEST(LidarTest, SensorWalkingTowardsAWallSeesItComeNearerColumnByColumn) {
  constexpr double kWallX = 10.0, kSpeed = 2.0, kStamp = 3.0;
  Raycaster raycaster(Scene({Part(BoxMesh({0.5, 200, 200}, At(kWallX + 0.5, 0, 0)))}));
  core::PoseTrajectory walk;
  for (int i = 0; i <= 4; ++i) walk.Add(kStamp + 0.03 * i, At(kSpeed * 0.03 * i, 0, 0));
  Lidar lidar(ExactLidar(), core::Rng(1));
  const core::LidarScan scan = lidar.Spin(&raycaster, kStamp, walk, nullptr, 1);
  size_t hits = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (scan.kind[i] != ReturnKind::kHit) continue;
    ++hits;
    const double expected = (kWallX - kSpeed * scan.time_s[i]) / scan.direction_lidar[i].x();
    ASSERT_NEAR(scan.range_m[i], expected, 2e-5 * expected + 2e-5);
  }
  EXPECT_GT(hits, 10000u);
}

TEST(LidarTest, RollingSensorSeesTheFloorAtEachColumnsOwnAttitude) {
  constexpr double kHeight = 0.8, kRollRate = 0.9;
  Raycaster raycaster(Scene({Part(BoxMesh({500, 500, 0.5}, At(0, 0, -0.5)))}));
  core::PoseTrajectory roll;
  for (int i = 0; i <= 10; ++i) {
    roll.Add(0.01 * i, core::MakePose(core::RotationFromYawPitchRoll(0.3, 0.0, kRollRate * 0.01 * i),
                                      core::Vec3(0, 0, kHeight)));
  }
  const core::LidarScan scan = Lidar(ExactLidar(), core::Rng(1)).Spin(&raycaster, 0.0, roll, nullptr, 1);
  size_t hits = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (scan.kind[i] != ReturnKind::kHit || scan.range_m[i] > 20.0f) continue;
    ++hits;
    const core::Mat3 R = core::RotationFromYawPitchRoll(0.3, 0.0, kRollRate * scan.time_s[i]);
    const double expected = -kHeight / (R * scan.direction_lidar[i].cast<double>()).z();
    ASSERT_NEAR(scan.range_m[i], expected, 1e-5 * expected * expected + 1e-5);
  }
  EXPECT_GT(hits, 5000u);
}

TEST(LidarTest, BeamsThatMeetNothingAreVoidAndThoseTooNearAreDropouts) {
  Lidar lidar(ExactLidar(), core::Rng(1));
  Raycaster nothing{scenes::SceneSpec{}};
  EXPECT_EQ(Count(lidar.Spin(&nothing, 0, Still(), nullptr, 1), ReturnKind::kVoid), 28800u);
  Raycaster beyond(Scene({Part(BoxMesh({150, 150, 150}))}));
  EXPECT_EQ(Count(lidar.Spin(&beyond, 0, Still(), nullptr, 1), ReturnKind::kVoid), 28800u);
  Raycaster tight(Scene({Part(SphereMesh(0.39, 32, core::Pose::Identity()))}));
  EXPECT_EQ(Count(lidar.Spin(&tight, 0, Still(), nullptr, 1), ReturnKind::kDropout), 28800u);
  Raycaster room(Scene({Part(BoxMesh({3, 3, 3}))}));
  const core::LidarScan scan = lidar.Spin(&room, 0, Still(), nullptr, 1);
  EXPECT_EQ(Count(scan, ReturnKind::kHit), 28800u);
  for (const float range : scan.range_m) ASSERT_GE(range, 2.9999f);
}

TEST(LidarTest, RobotsOwnBodyIsADropoutByGeometry) {
  Raycaster raycaster(Scene({Part(BoxMesh({5, 5, 5}))}));
  const core::Vec3 half(0.1, 0.1, 0.3);
  raycaster.AddBody(BoxMesh(half));
  const core::Pose T_map_body = At(1.0, 0.2, -0.1);
  raycaster.SetBodyPose(0, T_map_body);
  const core::LidarScan scan = Lidar(ExactLidar(), core::Rng(1)).Spin(&raycaster, 0, Still(), nullptr, 1);
  const core::Box3 body{T_map_body.translation() - half, T_map_body.translation() + half};
  size_t dropouts = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    const auto crossing =
        body.Inflated(1e-5).Clip(core::Vec3::Zero(), scan.direction_lidar[i].cast<double>());
    const auto inside = body.Inflated(-1e-5).Clip(core::Vec3::Zero(), scan.direction_lidar[i].cast<double>());
    if (crossing.has_value() != inside.has_value()) continue;  // grazes an edge
    ASSERT_EQ(scan.kind[i], crossing ? ReturnKind::kDropout : ReturnKind::kHit);
    dropouts += crossing ? 1 : 0;
  }
  EXPECT_GT(dropouts, 300u);
}

TEST(LidarTest, ReturnsWithinTwoCentimetresOfTheRobotAreDropouts) {
  constexpr double kFloor = -0.5, kMargin = 0.02;
  Raycaster raycaster(Scene({Part(BoxMesh({50, 50, 1}, At(0, 0, kFloor - 1.0)))}));
  // A plate that stands on edge on the floor: only returns beside its foot are near it.
  const core::Vec3 half(0.2, 0.001, 0.005);
  raycaster.AddBody(BoxMesh(half));
  raycaster.SetBodyPose(0, At(2.2, 0, kFloor + 0.005));
  const core::LidarScan scan = Lidar(ExactLidar(), core::Rng(1)).Spin(&raycaster, 0, Still(), nullptr, 1);
  size_t near = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    const core::Vec3 d = scan.direction_lidar[i].cast<double>();
    if (d.z() >= -1e-3) continue;
    const core::Vec3 p = d * (kFloor / d.z());
    const core::Box3 body{core::Vec3(2.0, -0.001, kFloor), core::Vec3(2.4, 0.001, kFloor + 0.01)};
    if (body.Inflated(1e-4).Clip(core::Vec3::Zero(), d) || std::abs(body.DistanceTo(p) - kMargin) < 1e-4)
      continue;
    if (p.norm() > 99.0) continue;
    const bool expect_self = body.DistanceTo(p) < kMargin;
    near += expect_self ? 1 : 0;
    ASSERT_EQ(scan.kind[i], expect_self ? ReturnKind::kDropout : ReturnKind::kHit) << p.transpose();
  }
  EXPECT_GT(near, 3u);
}

TEST(LidarTest, BodiesArePosedInSlicesAcrossTheRevolution) {
  Raycaster raycaster(Scene({Part(BoxMesh({5, 5, 5}))}));
  raycaster.AddBody(BoxMesh({0.1, 0.1, 0.1}));
  std::vector<double> times;
  Lidar(ExactLidar(), core::Rng(1))
      .Spin(
          &raycaster, 2.0, Still(), [&](double t) { times.push_back(t); }, 1);
  ASSERT_GE(times.size(), 4u);
  ASSERT_LE(times.size(), 8u);
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  EXPECT_GT(times.front(), 2.0);
  EXPECT_LT(times.back(), 2.1);
}

TEST(LidarTest, NoiseHasTheModelsSpreadAndThreeSigmaLimit) {
  core::LidarModel model = core::FindLidarModel("vlp16");
  model.range_sigma_m = 0.02;
  model.dropout_probability = 0.05;
  Raycaster raycaster(Scene({Part(SphereMesh(5.0, 512, core::Pose::Identity()))}));
  Lidar exact(ExactLidar(), core::Rng(1)), noisy(model, core::Rng(1));
  const core::LidarScan truth = exact.Spin(&raycaster, 0, Still(), nullptr, 1);
  const core::LidarScan scan = noisy.Spin(&raycaster, 0, Still(), nullptr, 1);
  double sum = 0.0, sum2 = 0.0, sum_next = 0.0, previous = 0.0;
  size_t n = 0;
  for (size_t i = 0; i < scan.size(); ++i) {
    if (scan.kind[i] != ReturnKind::kHit) continue;
    const double error = scan.range_m[i] - truth.range_m[i];
    ASSERT_LE(std::abs(error), 0.06 + 1e-5);
    sum += error;
    sum2 += error * error;
    sum_next += error * previous;
    previous = error;
    ++n;
  }
  const auto count = static_cast<double>(n);
  EXPECT_NEAR(sum / count, 0.0, 4.0 * 0.02 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(sum2 / count), 0.02 * 0.9975, 0.02 * 0.02);  // E[min(|z|, 3)^2] = 0.995
  EXPECT_NEAR(sum_next / sum2, 0.0, 4.0 / std::sqrt(count));
  EXPECT_NEAR(1.0 - count / 28800.0, 0.05, 4.0 * std::sqrt(0.05 * 0.95 / 28800.0));
}

TEST(LidarTest, ThreadsDoNotChangeAScanAndSpinsDiffer) {
  core::LidarModel model = core::FindLidarModel("os1_64");
  model.dropout_probability = 0.01;
  core::PoseTrajectory walk;
  walk.Add(0.0, At(0, 0, 0));
  walk.Add(0.2, core::MakePose(core::RotationFromYawPitchRoll(0.2, 0.1, 0.3), core::Vec3(0.3, 0.1, 0)));
  const auto spin_twice = [&](int threads) {
    Raycaster raycaster(Scene({Part(BoxMesh({4, 3, 2})), Part(BoxMesh({0.5, 0.5, 0.5}, At(2, 1, 0)), 0.5)}));
    raycaster.AddBody(BoxMesh({0.2, 0.1, 0.1}));
    const auto pose = [&](double t) { raycaster.SetBodyPose(0, At(-0.8 + t, 0, 0)); };
    Lidar lidar(model, core::Rng(4));
    core::LidarScan first = lidar.Spin(&raycaster, 0.0, walk, pose, threads);
    return std::pair{first, lidar.Spin(&raycaster, 0.1, walk, pose, threads)};
  };
  const auto [first, second] = spin_twice(1);
  for (const int threads : {2, 5}) {
    const auto [again, after] = spin_twice(threads);
    EXPECT_EQ(first.range_m, again.range_m);
    EXPECT_EQ(first.kind, again.kind);
    EXPECT_EQ(second.range_m, after.range_m);
    EXPECT_EQ(second.kind, after.kind);
  }
  EXPECT_NE(first.kind, second.kind);
}

}  // namespace
}  // namespace atlas::sim
