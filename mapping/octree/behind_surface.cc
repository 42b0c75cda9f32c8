#include "mapping/octree/behind_surface.h"

namespace atlas::mapping {

BehindSurface::BehindSurface(double resolution_m, double depth_m)
    : resolution_m_(resolution_m), depth_m_(depth_m) {}

void BehindSurface::Mark(const UndistortedSpin& spin, double max_range_m) {
  hit_.clear();
  for (const MapRay& ray : spin.hits) {
    if (ray.range_m > static_cast<float>(max_range_m)) continue;
    const core::Vec3 direction = ray.direction_map.cast<double>();
    const core::Vec3 end = ray.origin_map.cast<double>() + static_cast<double>(ray.range_m) * direction;
    if (!hit_.insert(PackedKey(VoxelKeyAt(end, 1.0 / resolution_m_))).second) continue;
    ForEachBehind(end, direction, resolution_m_, depth_m_, [&](const core::Vec3& p_map, int value) {
      const NodeKey voxel = VoxelKeyAt(p_map, 1.0 / resolution_m_);
      uint8_t& mark = blocks_.try_emplace(PackedKey(voxel.Up(kBlockLevel)), Block{})
                          .first->second[static_cast<size_t>(VoxelIndex(voxel.x, voxel.y, voxel.z))];
      mark = std::max(mark, static_cast<uint8_t>(value));
      return true;
    });
  }
}

const BehindSurface::Block* BehindSurface::Find(const NodeKey& voxel) const {
  const auto found = blocks_.find(PackedKey(voxel.Up(kBlockLevel)));
  return found == blocks_.end() ? nullptr : &found->second;
}

}  // namespace atlas::mapping
