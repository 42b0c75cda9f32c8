// A LiDAR before a shape of closed form: revolutions without any ray caster.
#pragma once

#include <vector>

#include "core/lidar_model.h"
#include "core/rng.h"
#include "core/sensor_events.h"
#include "tests/support/analytic_shapes.h"

namespace atlas::tests {

/// One revolution from a LiDAR at rest. Rays that meet nothing in range are void.
inline core::SpinEvent ScanShape(const AnalyticShape& shape, const core::LidarModel& lidar,
                                 const core::Pose& T_odom_lidar, double noise_m, core::Rng* rng) {
  core::SpinEvent spin;
  core::LidarScan& scan = spin.scan;
  scan.rows = lidar.rows();
  scan.columns = lidar.columns;
  scan.min_range_m = static_cast<float>(lidar.min_range_m);
  scan.max_range_m = static_cast<float>(lidar.max_range_m);
  for (int row = 0; row < lidar.rows(); ++row) {
    for (int column = 0; column < lidar.columns; ++column) {
      const core::Vec3 direction = lidar.Direction(row, column);
      const auto range = shape.Cast(T_odom_lidar.translation(), T_odom_lidar.linear() * direction);
      const bool hit = range && *range >= lidar.min_range_m && *range <= lidar.max_range_m;
      scan.direction_lidar.push_back(direction.cast<float>());
      scan.range_m.push_back(hit ? static_cast<float>(*range + noise_m * rng->Normal()) : 0.0f);
      scan.time_s.push_back(static_cast<float>(column / (lidar.spin_rate_hz * lidar.columns)));
      scan.kind.push_back(hit ? core::ReturnKind::kHit : core::ReturnKind::kVoid);
    }
  }
  spin.T_odom_lidar.Add(0.0, T_odom_lidar);
  return spin;
}

/// `count` poses on a ring around `center`, at alternating heights, each turned and tilted a little.
inline std::vector<core::Pose> RingOfPoses(const core::Vec3& center, double radius_m, double low_m,
                                           double high_m, int count, core::Rng* rng) {
  std::vector<core::Pose> poses;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * core::kPi * (i + 0.3 * rng->Uniform()) / count;
    const core::Vec3 p = center + core::Vec3(radius_m * std::cos(angle), radius_m * std::sin(angle),
                                             low_m + (high_m - low_m) * (i % 3) / 2.0);
    poses.push_back(
        core::MakePose(core::RotationFromYawPitchRoll(rng->Uniform(-core::kPi, core::kPi),
                                                      rng->Uniform(-0.15, 0.15), rng->Uniform(-0.15, 0.15)),
                       p));
  }
  return poses;
}

}  // namespace atlas::tests
