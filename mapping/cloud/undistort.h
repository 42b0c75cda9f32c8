// From a spin in the moving LiDAR frame to rays in the map frame.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/sensor_events.h"

namespace atlas::mapping {

/// A scan ray in the map frame: origin and end (hit), or origin and unit direction (void).
struct MapRay {
  core::Vec3f origin_map;
  core::Vec3f direction_map;
  float range_m = 0.0f;  ///< 0 for void rays
};

/// Rays of one spin by per-ray time: odom first, then map (thesis 3.3). Dropouts and isolated returns (no
/// neighbour in the row at a like range: mixed pixels, dust) are left out.
struct UndistortedSpin {
  std::vector<MapRay> hits;
  std::vector<MapRay> voids;
};
void Undistort(const core::SpinEvent& spin, const core::Pose& T_map_odom, UndistortedSpin* out);
/// The same without its voids.
void UndistortHits(const core::SpinEvent& spin, const core::Pose& T_map_odom, UndistortedSpin* out);

}  // namespace atlas::mapping
