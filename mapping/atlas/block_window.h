// Blocks of a tree about one place, their chunks looked up once: for the hundreds of voxels that a block of
// another submap asks about.
#pragma once

#include <array>
#include <vector>

#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// Finds chunks of a tree, remembering those about the last place. @pre nobody writes
class NearbyChunks {
 public:
  explicit NearbyChunks(const OccupancyOctree& tree) : tree_(tree) {}
  const OccupancyOctree::Chunk* Find(const NodeKey& chunk) {
    Slot& slot = slots_[static_cast<size_t>((chunk.x & 1) | (chunk.y & 1) << 1 | (chunk.z & 1) << 2)];
    if (!slot.asked || !(slot.key == chunk)) slot = {chunk, tree_.Find(chunk), true};
    return slot.chunk;
  }
  int8_t At(const NodeKey& voxel) {
    const OccupancyOctree::Chunk* const chunk = Find(voxel.Up(kChunkLevel));
    return chunk == nullptr
               ? OccupancyField::Unknown()
               : tree_.ValueIn(*chunk, BlockIndexOf(voxel), VoxelIndex(voxel.x, voxel.y, voxel.z));
  }

 private:
  struct Slot {
    NodeKey key;
    const OccupancyOctree::Chunk* chunk = nullptr;
    bool asked = false;
  };
  const OccupancyOctree& tree_;
  std::array<Slot, 8> slots_;  ///< by parity: any two by two by two chunks fit
};

/// @pre nobody writes while a window is used
class BlockWindow {
 public:
  explicit BlockWindow(const OccupancyOctree& tree) : tree_(tree), chunks_(tree) {}

  /// To the blocks from `low` to `high`, both inclusive.
  void MoveTo(const NodeKey& low, const NodeKey& high);
  bool Holds(const NodeKey& block) const {
    return InAxis(block.x - low_.x, size_[0]) && InAxis(block.y - low_.y, size_[1]) &&
           InAxis(block.z - low_.z, size_[2]);
  }
  /// @pre Holds(voxel.Up(kBlockLevel))
  int8_t At(const NodeKey& voxel) const {
    const int x = (voxel.x >> kBlockLevel) - low_.x, y = (voxel.y >> kBlockLevel) - low_.y,
              z = (voxel.z >> kBlockLevel) - low_.z;
    const Leaf& leaf = leaves_[static_cast<size_t>((z * size_[1] + y) * size_[0] + x)];
    return leaf.values[leaf.cell_of[VoxelIndex(voxel.x, voxel.y, voxel.z)]];
  }
  /// Also outside the window.
  int8_t AtAny(const NodeKey& voxel) { return Holds(voxel.Up(kBlockLevel)) ? At(voxel) : chunks_.At(voxel); }

  /// How its blocks are stored at the finest, and the one value of all, where there is one.
  BlockKind finest() const { return finest_; }
  bool one_value() const { return one_value_; }
  int8_t value() const { return value_; }

 private:
  struct Leaf {
    const int8_t* values;
    const uint16_t* cell_of;  ///< which of the values a voxel of the block has
  };
  static bool InAxis(int offset, int size) { return offset >= 0 && offset < size; }
  Leaf LeafOf(const NodeKey& block);

  const OccupancyOctree& tree_;
  NearbyChunks chunks_;
  NodeKey low_;
  std::array<int, 3> size_ = {0, 0, 0};  ///< blocks
  std::vector<Leaf> leaves_;             ///< x fastest
  BlockKind finest_ = BlockKind::kUniform;
  bool one_value_ = true;
  int8_t value_ = OccupancyField::Unknown();
};

}  // namespace atlas::mapping
