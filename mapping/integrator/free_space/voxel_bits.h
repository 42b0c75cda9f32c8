// The voxels of a block as bits, and its cells of 2^3 and 4^3 voxels.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "mapping/octree/morton.h"

namespace atlas::mapping {

/// A bit a voxel of a block, by z-layers.
struct VoxelBits {
  std::array<uint64_t, kBlockSide> layer;
};
/// The 8 voxels along one axis from `corner` that lie in [min, max).
inline uint32_t KeptAlong(int corner, int min, int max) {
  const int first = std::clamp(min - corner, 0, 8), last = std::clamp(max - corner, 0, 8);
  return first >= last ? 0u : (0xffu >> (8 - (last - first))) << first;
}

/// Bits of the 2^3 cells as bits of voxels.
inline VoxelBits ToVoxels(uint64_t cells) {
  VoxelBits out;
  for (int i = 0; i < 4; ++i) {
    uint64_t layer = cells >> (16 * i) & 0xffff;  // bit x + 4 y to bit 2 x + 16 y
    layer = (layer | layer << 24) & 0x000000ff000000ff;
    layer = (layer | layer << 12) & 0x000f000f000f000f;
    layer = (layer | layer << 2) & 0x0033003300330033;
    layer = (layer | layer << 1) & 0x0055005500550055;
    layer |= layer << 1;
    layer |= layer << 8;
    out.layer[static_cast<size_t>(2 * i)] = out.layer[static_cast<size_t>(2 * i + 1)] = layer;
  }
  return out;
}

/// Bits of 8 cells of 4^3 as bits of 64 cells of 2^3.
inline uint64_t ToCells(uint64_t octants) {
  uint64_t out = 0;
  for (uint64_t bits = octants; bits != 0; bits &= bits - 1) {
    const int octant = __builtin_ctzll(bits);
    out |= uint64_t{0x330033} << (2 * (octant & 1) + 8 * (octant >> 1 & 1) + 32 * (octant >> 2));
  }
  return out;
}

/// The free voxels beside voxels that are not: a surface that beams pass closely may run through those.
/// Beyond a block's sides all is as at the sides.
inline VoxelBits EdgeOf(const VoxelBits& free) {
  constexpr uint64_t kFirstX = 0x0101010101010101, kLastX = kFirstX << 7, kFirstY = 0xff,
                     kLastY = kFirstY << 56;
  VoxelBits out;
  for (size_t z = 0; z < 8; ++z) {
    const uint64_t l = free.layer[z];
    const uint64_t x = ((l << 1 & ~kFirstX) | (l & kFirstX)) & ((l >> 1 & ~kLastX) | (l & kLastX));
    const uint64_t y = (l << 8 | (l & kFirstY)) & (l >> 8 | (l & kLastY));
    out.layer[z] = l & ~(x & y & free.layer[z == 0 ? 0 : z - 1] & free.layer[z == 7 ? 7 : z + 1]);
  }
  return out;
}

}  // namespace atlas::mapping
