// A spinning LiDAR that moves while it spins.
#pragma once

#include <functional>

#include "core/lidar_model.h"
#include "core/rng.h"
#include "core/sensor_events.h"
#include "sim/sensors/raycaster.h"

namespace atlas::sim {

/// Casts revolutions from the true sensor pose at each ray's own time, adds range noise and dropout, and
/// marks rays that met nothing as void. Hits on the robot itself come back as dropouts.
class Lidar {
 public:
  Lidar(const core::LidarModel& model, const core::Rng& rng);
  const core::LidarModel& model() const { return model_; }

  /// Where the sensor and the robot's bodies truly were: `T_map_lidar` spans the revolution from stamp_s;
  /// `pose_bodies_at(t)` sets the raycaster's bodies for time t (called for a few slices of the revolution).
  core::LidarScan Spin(Raycaster* raycaster, double stamp_s, const core::PoseTrajectory& T_map_lidar,
                       const std::function<void(double)>& pose_bodies_at, int threads);

 private:
  core::LidarModel model_;
  uint64_t noise_seed_;
  uint64_t spin_count_ = 0;
  std::vector<core::Vec3f> direction_;  ///< a ray each, row-major
};

}  // namespace atlas::sim
