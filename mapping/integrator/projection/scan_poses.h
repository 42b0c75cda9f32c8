// Where the LiDAR was while a revolution lasted (thesis 4.5.3).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/sensor_events.h"

namespace atlas::mapping {

/// Poses of the LiDAR through the revolution against its middle, a column each, as rows of 3 x 4 matrices.
struct ColumnPoses {
  core::Pose T_odom_mid;
  bool moving = false;
  std::array<std::vector<float>, 12> T_mid_lidar;  ///< a column each, where moving
  std::vector<int32_t> pose_of_ray;  ///< where the rays of a column do not share a time; else empty
};
void PosesOfScan(const core::SpinEvent& spin, bool motion_aware, ColumnPoses* poses);

}  // namespace atlas::mapping
