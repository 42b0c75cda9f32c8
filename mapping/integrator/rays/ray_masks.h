// The voxels that the rays of a scan hit and cross, as bit masks a block.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "mapping/octree/morton.h"

namespace atlas::mapping {

class RayMasks {
 public:
  struct Block {
    NodeKey key;  ///< blocks
    uint64_t free[8], hit[8], end[8];
    uint32_t distances;  ///< slot of its distances; 0 none
  };
  using Distances = std::array<int16_t, kBlockVoxels>;  ///< kNoDistance where none

  void Clear();
  /// Marks a hit; returns whether the voxel had none.
  bool MarkHit(const NodeKey& voxel) { return SetBit(At(voxel).hit, voxel); }
  /// Marks the end of a ray that met nothing; returns whether it is the first there.
  bool MarkMissEnd(const NodeKey& voxel) { return SetBit(At(voxel).end, voxel); }
  void MarkFree(const NodeKey& voxel) { SetBit(At(voxel).free, voxel); }
  /// Keeps the distance nearest to 0 (of +-d the positive one).
  void MarkDistance(const NodeKey& voxel, int16_t distance);

  const Block& block(uint32_t slot) const { return blocks_[slot]; }
  const Distances& distances(uint32_t slot) const { return distances_[slot]; }

  struct ChunkGroup {
    NodeKey chunk;
    std::vector<uint32_t> blocks;  ///< slots, by ascending block index
  };
  /// All blocks, by ascending Morton code.
  std::vector<ChunkGroup> ByChunk() const;

 private:
  static bool SetBit(uint64_t* layers, const NodeKey& voxel) {
    uint64_t& layer = layers[voxel.z & 7];
    const uint64_t bit = uint64_t{1} << ((voxel.x & 7) | (voxel.y & 7) << 3);
    const bool first = (layer & bit) == 0;
    layer |= bit;
    return first;
  }
  Block& At(const NodeKey& voxel) {
    const NodeKey key = voxel.Up(kBlockLevel);
    if (!(key == last_key_) || last_ == 0) {
      last_ = Slot(key);
      last_key_ = key;
    }
    return blocks_[last_];
  }
  uint32_t Slot(const NodeKey& key);
  void Grow();

  std::vector<Block> blocks_;         // from 1
  std::vector<Distances> distances_;  // from 1
  std::vector<uint32_t> table_;       // open addressing, power of two; 0 empty
  NodeKey last_key_;
  uint32_t last_ = 0;
};

}  // namespace atlas::mapping
