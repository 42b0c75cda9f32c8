// The filtered cloud of a sweep, as every backend returns it (thesis 3.3).
#pragma once

#include "core/mesh.h"
#include "mapping/grid/dense_grid.h"
#include "mapping/mapper.h"
#include "mapping/undistort.h"

namespace atlas::mapping {

/// Collects the hits of the spins of one sweep: inside the region and the range, one a cell of downsample_m.
class SweepCloud {
 public:
  SweepCloud(const MapperParams& params, const core::Box3& region_map)
      : filter_(params.downsample_m),
        max_range_m_(static_cast<float>(params.integrator.max_range_m)),
        region_min_(region_map.min.cast<float>()),
        region_max_(region_map.max.cast<float>()) {}

  void Add(const UndistortedSpin& spin) {
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > max_range_m_) continue;
      const core::Vec3f p = ray.origin_map + ray.range_m * ray.direction_map;
      if ((p.array() < region_min_.array()).any() || (p.array() > region_max_.array()).any()) continue;
      if (filter_.Insert(p)) cloud_.Add(p, ray.origin_map);
    }
  }
  ReturnCloud Take() { return std::move(cloud_); }

 private:
  VoxelFilter filter_;
  ReturnCloud cloud_;
  float max_range_m_;
  core::Vec3f region_min_, region_max_;
};

/// Calls `mark(index, D - delta)` on the voxels that lie delta steps behind a hit, up to the depth (proximity
/// count gain, Isler 2016; D = 2 depth / resolution).
template <typename Mark>
void MarkBehindSurface(const GridFrame& frame, const core::Vec3& end_map, const core::Vec3& direction_map,
                       double depth_m, const Mark& mark) {
  const double resolution_m = frame.resolution_m();
  const int depth = static_cast<int>(std::round(depth_m / resolution_m));
  for (int delta = 1; delta <= depth; ++delta) {
    const int64_t index = frame.IndexAt(end_map + delta * resolution_m * direction_map);
    if (index < 0) return;
    mark(static_cast<size_t>(index), 2 * depth - delta);
  }
}

}  // namespace atlas::mapping
