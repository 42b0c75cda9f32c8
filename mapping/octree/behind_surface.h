// Unmeasured voxels behind hits, for the proximity count gain: a sparse layer beside a map.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>

#include "core/byte_reader.h"
#include "mapping/cloud/undistort.h"
#include "mapping/octree/morton.h"

namespace atlas::mapping {

constexpr int kMostBehind = 31;  ///< voxels, that a mark counts: what a dense grid's cell has room for

/// Calls visit(p_map, value) for the points that lie delta steps of a voxel behind a hit, delta = 1 .. D / 2,
/// nearest first, with D - delta (Isler 2016; D = 2 depth / resolution), at most kMostBehind; while `visit`
/// returns true.
template <typename Visit>
void ForEachBehind(const core::Vec3& end_map, const core::Vec3& direction_map, double resolution_m,
                   double depth_m, const Visit& visit) {
  const int depth = static_cast<int>(std::round(depth_m / resolution_m));
  for (int delta = 1; delta <= depth; ++delta) {
    const core::Vec3 p_map = end_map + delta * resolution_m * direction_map;
    if (!visit(p_map, std::min(2 * depth - delta, kMostBehind))) return;
  }
}

/// By voxel.
class BehindSurface {
 public:
  using Block = std::array<uint8_t, kBlockVoxels>;  ///< by VoxelIndex; 0 where nothing lies before

  BehindSurface(double resolution_m, double depth_m);

  /// Marks the voxels behind each hit; the greatest value stays. Once a revolution for each voxel that was
  /// hit, by its first ray.
  void Mark(const UndistortedSpin& spin, double max_range_m);
  /// The block of a voxel, or null.
  const Block* Find(const NodeKey& voxel) const;
  /// Takes over the marks of a map that lies turned and shifted, each to the voxel that its middle falls in.
  void Merge(const BehindSurface& other, const core::Pose& T_here_other);
  /// As bytes, the same for the same marks.
  void AppendTo(std::string* out) const;
  /// What AppendTo wrote. @throws InputError where it ends early.
  static BehindSurface Read(core::ByteReader* reader);
  size_t Bytes() const { return blocks_.size() * (sizeof(Block) + 4 * sizeof(void*)); }

 private:
  double resolution_m_, depth_m_;
  std::unordered_map<uint64_t, Block> blocks_;
  std::unordered_set<uint64_t> hit_;  ///< voxels of one revolution
};

/// The voxel of PackedKey's number.
inline NodeKey UnpackedKey(uint64_t key) {
  const auto bits = [](uint64_t v) { return static_cast<int32_t>(v & 0x1fffff) - (1 << 20); };
  return {bits(key), bits(key >> 21), bits(key >> 42)};
}

/// A number of its own for each voxel within a million voxels of the origin.
inline uint64_t PackedKey(const NodeKey& voxel) {
  const auto bits = [](int32_t v) { return static_cast<uint64_t>(v + (1 << 20)) & 0x1fffff; };
  return bits(voxel.x) | bits(voxel.y) << 21 | bits(voxel.z) << 42;
}

}  // namespace atlas::mapping
