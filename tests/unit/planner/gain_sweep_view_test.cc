// The sweep's field of view against rotating every beam through the roll. Whether the roll is that of the
// simulator is for tests/unit/experiments/sweep_prediction_test.cc.
#include <gtest/gtest.h>

#include "core/rng.h"
#include "planner/gain/sweep_view.h"

namespace atlas::planner {
namespace {

using core::Degrees;
using core::Radians;
using core::Vec3;

SweepSensorModel Vlp16Sweep() {
  SweepSensorModel sensor;
  sensor.lidar = core::FindLidarModel("vlp16");
  sensor.roll = {Radians(40.0), 6.0};
  return sensor;
}

Vec3 Direction(double azimuth_rad, double elevation_rad) {
  return {std::cos(elevation_rad) * std::cos(azimuth_rad), std::cos(elevation_rad) * std::sin(azimuth_rad),
          std::sin(elevation_rad)};
}

double HighestSeen(const SweepView& view, double azimuth_deg) {
  double elevation = 0.0;
  while (elevation < 90.0 && view.Sees(Direction(Radians(azimuth_deg), Radians(elevation))))
    elevation += 0.05;
  return elevation;
}

TEST(SweepView, RollWidensTheViewAbeamOnly) {
  const SweepView view(Vlp16Sweep());
  EXPECT_NEAR(HighestSeen(view, 90.0), 55.0, 0.1);
  EXPECT_NEAR(HighestSeen(view, -90.0), 55.0, 0.1);
  EXPECT_NEAR(HighestSeen(view, 45.0), 48.0, 0.8);
  EXPECT_NEAR(HighestSeen(view, 0.0), 20.0, 0.4);
  EXPECT_NEAR(HighestSeen(view, 180.0), 20.0, 0.4);
  EXPECT_NEAR(Degrees(view.common_elevation_max_rad()), 19.75, 0.2);
  EXPECT_NEAR(Degrees(view.elevation_max_rad()), 55.0, 0.2);
}

/// Rays of a whole sweep by brute force: every beam of every column at many rolls, turned into the base frame
/// and counted in bands of azimuth and elevation.
TEST(SweepView, DensityEqualsCountingRotatedBeams) {
  SweepSensorModel sensor = Vlp16Sweep();
  sensor.T_base_lidar.linear() = core::RotationFromYawPitchRoll(0.3, 0.1, 0.0);
  const SweepView view(sensor);
  constexpr int kRolls = 800, kColumns = 360, kBand_deg = 10;
  const double whole = 16.0 * sensor.lidar.columns * sensor.lidar.spin_rate_hz * 6.0;
  std::vector<double> counted(36 * 18, 0.0), predicted(36 * 18, 0.0);
  for (int r = 0; r < kRolls; ++r) {
    const double time_s = 6.0 * (r + 0.5) / kRolls;
    const core::Mat3 R =
        core::RotationFromYawPitchRoll(0, 0, sensor.roll.At(time_s).roll_rad) * sensor.T_base_lidar.linear();
    for (const double beam : sensor.lidar.elevation_rad) {
      for (int c = 0; c < kColumns; ++c) {
        const Vec3 d = R * Direction(2.0 * core::kPi * c / kColumns, beam);
        const int column = static_cast<int>(std::floor(Degrees(std::atan2(d.y(), d.x())) / kBand_deg)) + 18;
        const int row = static_cast<int>(std::floor(Degrees(std::asin(d.z())) / kBand_deg)) + 9;
        counted[static_cast<size_t>(std::clamp(row, 0, 17) * 36 + (column + 36) % 36)] +=
            whole / (16.0 * kRolls * kColumns);
      }
    }
  }
  for (int e = 0; e < 360; ++e) {
    for (int a = 0; a < 720; ++a) {
      const double elevation = Radians(-90.0 + (e + 0.5) / 2.0), azimuth = Radians(-180.0 + (a + 0.5) / 2.0);
      const double solid_angle = Radians(0.5) * Radians(0.5) * std::cos(elevation);
      predicted[static_cast<size_t>(e / 20 * 36 + a / 20)] +=
          solid_angle * view.RaysPerSteradian(azimuth, elevation);
    }
  }
  double all_counted = 0.0, all_predicted = 0.0;
  for (size_t i = 0; i < counted.size(); ++i) {
    all_counted += counted[i];
    all_predicted += predicted[i];
    EXPECT_NEAR(predicted[i], counted[i], 0.12 * counted[i] + 0.0006 * whole) << "band " << i;
  }
  EXPECT_NEAR(all_predicted, all_counted, 0.01 * all_counted);
}

TEST(SweepView, SeesExactlyWhereSomeRollBringsABeamsInterval) {
  SweepSensorModel sensor = Vlp16Sweep();
  sensor.T_base_lidar.linear() = core::RotationFromYawPitchRoll(0.0, 0.15, -0.05);
  const SweepView view(sensor);
  core::Rng rng(7);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 d = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    double nearest = 1e9;  // to the beams' interval, over the roll; <= 0 inside
    for (int r = 0; r <= 800; ++r) {
      const double roll = Radians(40.0) * (r / 400.0 - 1.0);
      const Vec3 in_lidar =
          (core::RotationFromYawPitchRoll(0, 0, roll) * sensor.T_base_lidar.linear()).transpose() * d;
      nearest = std::min(nearest, std::abs(std::asin(in_lidar.z())) - Radians(15.0));
    }
    if (std::abs(nearest) < 1e-4) continue;  // too near the rim for this many steps
    EXPECT_EQ(view.Sees(d), nearest < 0.0) << d.transpose();
  }
}

}  // namespace
}  // namespace atlas::planner
