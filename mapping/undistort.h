// From a spin in the moving LiDAR frame to rays in the map frame.
#pragma once

#include <vector>

#include "core/geometry.h"
#include "core/mesh.h"
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

/// Keeps the first point in each cell of a grid; remembers cells across calls.
class VoxelFilter {
 public:
  explicit VoxelFilter(double cell_m) : inverse_cell_(1.0 / cell_m), table_(1u << 16, kEmpty) {}
  /// Whether `p` is the first in its cell. @pre |p| < 2^20 cells.
  bool Insert(const core::Vec3f& p);

 private:
  static constexpr uint64_t kEmpty = ~uint64_t{0};
  void Grow();
  double inverse_cell_;
  std::vector<uint64_t> table_;  // open addressing, power of two
  size_t size_ = 0;
};

}  // namespace atlas::mapping
