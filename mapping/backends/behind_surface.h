// Unmeasured voxels behind a hit, for the proximity count gain.
#pragma once

#include "mapping/grid/dense_grid.h"

namespace atlas::mapping {

/// Calls `mark(index, D - delta)` on the voxels that lie delta steps behind a hit, up to the depth (Isler
/// 2016; D = 2 depth / resolution).
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
