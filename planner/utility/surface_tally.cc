#include "planner/utility/surface_tally.h"

#include <cmath>

namespace atlas::planner {

SurfaceTally::SurfaceTally(const core::Box3& object_box, double voxel_m)
    : box_(object_box), voxel_m_(voxel_m) {
  size_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    size_[axis] = static_cast<int>(std::ceil(box_.Size()[axis] / voxel_m)) + 3;  // a rim of one
    count *= static_cast<size_t>(size_[axis]);
  }
  seen_.assign(count, false);
}

size_t SurfaceTally::IndexOf(const int cell[3]) const {
  return static_cast<size_t>(cell[0]) +
         static_cast<size_t>(size_[0]) *
             (static_cast<size_t>(cell[1]) + static_cast<size_t>(size_[1]) * static_cast<size_t>(cell[2]));
}

bool SurfaceTally::SeenAround(const int cell[3]) const {
  for (int k = 0; k < 27; ++k) {
    const int near[3] = {cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1};
    if (seen_[IndexOf(near)]) return true;
  }
  return false;
}

size_t SurfaceTally::CountNew(const std::vector<core::Vec3f>& occupied_map, const TraversableGround& ground) {
  std::vector<size_t> unseen;
  size_t fresh = 0;
  for (const core::Vec3f& center : occupied_map) {
    const core::Vec3 p = center.cast<double>();
    if (!box_.Contains(p)) continue;
    int cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      cell[axis] = static_cast<int>((p[axis] - box_.min[axis]) / voxel_m_) + 1;
    }
    const size_t index = IndexOf(cell);
    if (seen_[index] || p.z() < ground.SurfaceAt(p.head<2>()).height_m + 2.0 * voxel_m_) continue;
    unseen.push_back(index);
    if (!SeenAround(cell)) ++fresh;
  }
  for (const size_t index : unseen) seen_[index] = true;
  return fresh;
}

}  // namespace atlas::planner
