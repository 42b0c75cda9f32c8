// Where a voxel lies in the octree: integer coordinates at each level and their Morton codes.
//
// Level 0 is a voxel, level 3 a block (8 x 8 x 8 voxels, contiguous in memory), level 6 a chunk (8 x 8 x 8
// blocks). A node at level l spans 2^l voxels a side. Voxel (i, j, k) spans resolution * [i, i + 1) and so
// on, so its lattice coincides with OctoMap's.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/geometry.h"

namespace atlas::mapping {

constexpr int kBlockLevel = 3;
constexpr int kChunkLevel = 6;
constexpr int kBlockSide = 8;             ///< voxels
constexpr int kBlockVoxels = 512;         ///< 8^3
constexpr int kChunkSide = 64;            ///< voxels
constexpr int kChunkBlocks = 512;         ///< 8^3
constexpr int kKeyLimit = 1 << 26;        ///< |voxel coordinate| stays below: 3,300 km at 5 cm
constexpr int kChunkKeyOffset = 1 << 20;  ///< makes chunk coordinates positive in their Morton code

/// Integer coordinates of a node, in units of its own side.
struct NodeKey {
  int32_t x = 0, y = 0, z = 0;
  friend bool operator==(const NodeKey&, const NodeKey&) = default;
  /// The key of the ancestor `levels` above; floors towards minus infinity.
  NodeKey Up(int levels) const { return {x >> levels, y >> levels, z >> levels}; }
};

inline NodeKey VoxelKeyAt(const core::Vec3& p, double inverse_resolution) {
  return {static_cast<int32_t>(std::floor(p.x() * inverse_resolution)),
          static_cast<int32_t>(std::floor(p.y() * inverse_resolution)),
          static_cast<int32_t>(std::floor(p.z() * inverse_resolution))};
}

/// Spreads the low 21 bits of `v`, two zeros between neighbours.
constexpr uint64_t SpreadBits(uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}
constexpr uint32_t GatherBits(uint64_t v) {
  v &= 0x1249249249249249;
  v = (v | v >> 2) & 0x10c30c30c30c30c3;
  v = (v | v >> 4) & 0x100f00f00f00f00f;
  v = (v | v >> 8) & 0x001f0000ff0000ff;
  v = (v | v >> 16) & 0x001f00000000ffff;
  v = (v | v >> 32) & 0x1fffff;
  return static_cast<uint32_t>(v);
}

/// Morton code of three coordinates in [0, 2^21); x is the lowest bit.
constexpr uint64_t MortonCode(uint32_t x, uint32_t y, uint32_t z) {
  return SpreadBits(x) | SpreadBits(y) << 1 | SpreadBits(z) << 2;
}
/// Of a chunk's key. @pre |coordinates| < 2^20.
constexpr uint64_t ChunkCode(const NodeKey& chunk) {
  return MortonCode(static_cast<uint32_t>(chunk.x + kChunkKeyOffset),
                    static_cast<uint32_t>(chunk.y + kChunkKeyOffset),
                    static_cast<uint32_t>(chunk.z + kChunkKeyOffset));
}
constexpr NodeKey ChunkKeyOf(uint64_t code) {
  return {static_cast<int32_t>(GatherBits(code)) - kChunkKeyOffset,
          static_cast<int32_t>(GatherBits(code >> 1)) - kChunkKeyOffset,
          static_cast<int32_t>(GatherBits(code >> 2)) - kChunkKeyOffset};
}

/// Index in [0, 512) of a block in its chunk: Morton order, so the 8 (64) blocks of a level 4 (5) node are
/// neighbours.
constexpr int BlockIndex(int bx, int by, int bz) {
  const auto spread = [](int b) { return (b & 1) | (b & 2) << 2 | (b & 4) << 4; };
  return spread(bx) | spread(by) << 1 | spread(bz) << 2;
}
/// Block coordinates in [0, 8) of an index.
constexpr NodeKey BlockOffset(int block) {
  const auto b = static_cast<uint64_t>(block);
  return {static_cast<int32_t>(GatherBits(b)), static_cast<int32_t>(GatherBits(b >> 1)),
          static_cast<int32_t>(GatherBits(b >> 2))};
}
/// Block of a voxel key in its chunk.
constexpr int BlockIndexOf(const NodeKey& voxel) {
  return BlockIndex(voxel.x >> 3, voxel.y >> 3, voxel.z >> 3);
}

/// Index in [0, 512) of a voxel in its block: x fastest, so a z-layer is 64 neighbours.
constexpr int VoxelIndex(int x, int y, int z) {
  return (x & 7) | (y & 7) << 3 | (z & 7) << 6;
}
/// Index in [0, 64) of the 2 x 2 x 2 cell that holds voxel `index` of a block; x fastest.
constexpr int CellOfVoxel(int index) {
  return ((index & 7) >> 1) | ((index >> 3 & 7) >> 1) << 2 | (index >> 7) << 4;
}

}  // namespace atlas::mapping
