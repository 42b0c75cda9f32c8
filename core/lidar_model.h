// Spinning LiDAR models: beam table, firing order, limits and noise.
#pragma once

#include <string>
#include <vector>

#include "core/geometry.h"

namespace atlas::core {

/// One revolution is `columns` firings, each of all `beams`, spread evenly over 1 / spin_rate_hz seconds.
/// Column c points at azimuth -2 pi c / columns (clockwise seen from above) in the LiDAR frame (x forward, z
/// up), unless a recorded sensor's first azimuth and step say otherwise.
struct LidarModel {
  std::string name;
  std::vector<double> elevation_rad;       ///< a row each, any order
  std::vector<double> azimuth_offset_rad;  ///< a row each, added to the column's azimuth
  int columns = 0;
  double spin_rate_hz = 10.0;
  double min_range_m = 0.0;
  double max_range_m = 0.0;
  double range_sigma_m = 0.0;        ///< standard deviation of the range noise
  double dropout_probability = 0.0;  ///< chance that a ray returns no information
  double first_azimuth_rad = 0.0;    ///< of column 0
  double column_step_rad = 0.0;      ///< azimuth from a column to the next; 0: -2 pi / columns

  int rows() const { return static_cast<int>(elevation_rad.size()); }
  double StepRad() const;
  /// Where ray (row, column) points in the LiDAR frame: azimuth (any turn), unit direction.
  double AzimuthRad(int row, int column) const;
  Vec3 Direction(int row, int column) const;
};

/// "vlp16", "os1_64" or "os0_64" (thesis 2.7.1). @throws InputError for another name.
LidarModel FindLidarModel(const std::string& name);
std::vector<std::string> LidarModelNames();

}  // namespace atlas::core
