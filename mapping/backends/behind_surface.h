// Unmeasured voxels behind hits, for the proximity count gain: a sparse layer beside a map.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>

#include "mapping/cloud/undistort.h"
#include "mapping/octree/morton.h"

namespace atlas::mapping {

class BehindSurface {
 public:
  using Block = std::array<uint8_t, kBlockVoxels>;  ///< by VoxelIndex; 0 where nothing lies before

  BehindSurface(double resolution_m, double depth_m);

  /// Marks the voxels that lie delta steps behind each hit, up to the depth, with D - delta (Isler 2016; D =
  /// 2 depth / resolution); the greatest stays. Once a revolution for each voxel that was hit, by its first
  /// ray.
  void Mark(const UndistortedSpin& spin, double max_range_m);
  /// The block of a voxel, or null.
  const Block* Find(const NodeKey& voxel) const;
  size_t Bytes() const { return blocks_.size() * (sizeof(Block) + 4 * sizeof(void*)); }

 private:
  double resolution_m_;
  int depth_;  ///< voxels
  std::unordered_map<uint64_t, Block> blocks_;
  std::unordered_set<uint64_t> hit_;  ///< voxels of one revolution
};

/// A number of its own for each voxel within a million voxels of the origin.
inline uint64_t PackedKey(const NodeKey& voxel) {
  const auto bits = [](int32_t v) { return static_cast<uint64_t>(v + (1 << 20)) & 0x1fffff; };
  return bits(voxel.x) | bits(voxel.y) << 21 | bits(voxel.z) << 42;
}

}  // namespace atlas::mapping
