// Clouds that a known LiDAR would have recorded in a room, as drivers write them.
#pragma once

#include "core/lidar_model.h"
#include "core/rng.h"
#include "mapping/io/recorded_cloud.h"

namespace atlas::tests {

struct DriverQuirks {
  bool counter_clockwise = false;
  bool destaggered = false;  ///< rows shifted by whole columns, so that columns are azimuths
  bool bottom_row_first = false;
  double first_azimuth_rad = 0.0;
  double missing = 0.0;  ///< share of pixels without a return
  double point_noise_m = 0.0;
};

/// The model as the driver presents it: what is to be recovered.
inline core::LidarModel Presented(core::LidarModel model, const DriverQuirks& quirks) {
  model.first_azimuth_rad = quirks.first_azimuth_rad;
  model.column_step_rad = (quirks.counter_clockwise ? 2.0 : -2.0) * core::kPi / model.columns;
  if (quirks.destaggered) {
    for (double& offset : model.azimuth_offset_rad)
      offset -= std::round(offset / model.column_step_rad) * model.column_step_rad;
  }
  if (quirks.bottom_row_first) {
    std::reverse(model.elevation_rad.begin(), model.elevation_rad.end());
    std::reverse(model.azimuth_offset_rad.begin(), model.azimuth_offset_rad.end());
  }
  return model;
}

/// An organised cloud from the middle of a room of 12 x 8 x 5 m, at `p_map` in it; noise on every coordinate.
inline mapping::RecordedCloud RoomCloud(const core::LidarModel& model, const DriverQuirks& quirks,
                                        uint64_t seed, const core::Vec3& p_map = core::Vec3::Zero()) {
  core::Rng rng(seed);
  const core::Box3 room{core::Vec3(-6, -4, -2), core::Vec3(6, 4, 3)};
  mapping::RecordedCloud cloud;
  cloud.organised = true;
  cloud.rows = model.rows();
  cloud.columns = model.columns;
  for (int row = 0; row < cloud.rows; ++row) {
    for (int column = 0; column < cloud.columns; ++column) {
      const core::Vec3 direction = model.Direction(row, column);
      core::Vec3 p = room.Clip(p_map, direction)->second * direction;
      for (int k = 0; k < 3; ++k) p[k] += quirks.point_noise_m * rng.Normal();
      const bool missing = rng.Uniform() < quirks.missing;
      if (missing) p.setConstant(std::nan(""));
      cloud.p_lidar.push_back(p.cast<float>());
    }
  }
  return cloud;
}

}  // namespace atlas::tests
