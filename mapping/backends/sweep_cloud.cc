#include "mapping/backends/sweep_cloud.h"

namespace atlas::mapping {

void MarkBehindSurface(const core::Vec3& end_map, const core::Vec3& direction_map, double depth_m,
                       DenseGrid* grid) {
  const double resolution_m = grid->resolution_m();
  const int depth = static_cast<int>(std::round(depth_m / resolution_m));
  for (int delta = 1; delta <= depth; ++delta) {
    const int64_t index = grid->frame().IndexAt(end_map + delta * resolution_m * direction_map);
    if (index < 0) return;
    grid->SetBehindSurface(static_cast<size_t>(index), 2 * depth - delta);
  }
}

}  // namespace atlas::mapping
