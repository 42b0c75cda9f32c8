// The cloud of a scan (thesis 3.3): what its revolutions returned, in the map frame, thinned.
#pragma once

#include <vector>

#include "core/sensor_events.h"
#include "mapping/cloud/undistort.h"
#include "mapping/cloud/voxel_filter.h"

namespace atlas::mapping {

/// LiDAR returns in the map frame, and where the sensor was at the time of each.
struct ReturnCloud {
  std::vector<core::Vec3f> points;
  std::vector<core::Vec3f> origins;  ///< a point each

  void Add(const core::Vec3f& point, const core::Vec3f& origin) {
    points.push_back(point);
    origins.push_back(origin);
  }
};

/// Undistorted returns inside a box and a range, isolated ones left out, one a cell until the next Begin().
class ScanCloud {
 public:
  ScanCloud(const core::Box3& box_map, double max_range_m, double spacing_m);

  /// Forgets which cells have a point.
  void Begin() { filter_ = VoxelFilter(spacing_m_); }
  /// The returns of a revolution that are the first in their cells.
  ReturnCloud Add(const core::SpinEvent& spin, const core::Pose& T_map_odom);

 private:
  core::Vec3f min_, max_;
  float max_range_m_;
  double spacing_m_;
  VoxelFilter filter_;
  UndistortedSpin undistorted_;
};

}  // namespace atlas::mapping
