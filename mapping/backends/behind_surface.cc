#include "mapping/backends/behind_surface.h"

#include <algorithm>
#include <cmath>

namespace atlas::mapping {

BehindSurface::BehindSurface(double resolution_m, double depth_m)
    : resolution_m_(resolution_m), depth_(static_cast<int>(std::round(depth_m / resolution_m))) {}

void BehindSurface::Mark(const UndistortedSpin& spin, double max_range_m) {
  hit_.clear();
  for (const MapRay& ray : spin.hits) {
    if (ray.range_m > static_cast<float>(max_range_m)) continue;
    const core::Vec3 direction = ray.direction_map.cast<double>();
    const core::Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
    if (!hit_.insert(PackedKey(VoxelKeyAt(end, 1.0 / resolution_m_))).second) continue;
    for (int delta = 1; delta <= depth_; ++delta) {
      const NodeKey voxel = VoxelKeyAt(end + delta * resolution_m_ * direction, 1.0 / resolution_m_);
      uint8_t& value = blocks_.try_emplace(PackedKey(voxel.Up(kBlockLevel)), Block{})
                           .first->second[static_cast<size_t>(VoxelIndex(voxel.x, voxel.y, voxel.z))];
      value = static_cast<uint8_t>(std::max<int>(value, std::min(2 * depth_ - delta, 255)));
    }
  }
}

const BehindSurface::Block* BehindSurface::Find(const NodeKey& voxel) const {
  const auto found = blocks_.find(PackedKey(voxel.Up(kBlockLevel)));
  return found == blocks_.end() ? nullptr : &found->second;
}

}  // namespace atlas::mapping
