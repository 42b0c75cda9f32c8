// The multi-resolution octree of SE-Atlas (thesis 4.5; supereight, Vespa et al.).
//
// Roots are chunks of 64^3 voxels in a hash table. A chunk holds 512 blocks in Morton order; a
// block is uniform (one value for its 512 voxels), coarse (64 cells of 2 x 2 x 2) or fine (512 voxels, x
// fastest), so free space costs a byte a block and surfaces a leaf. Nodes at levels 3 to 6 (block to chunk)
// know what lies below them (`Field::Node`: maximum occupancy and observed state, or mean distance and
// weight), once Propagate has run.
//
// Threads: chunks may be written at the same time by different workers, a chunk by one. Creating and erasing
// chunks is for one thread alone. Queries are const and may run together while nobody writes.
#pragma once

#include <memory>
#include <vector>

#include "mapping/octree/chunk_table.h"
#include "mapping/octree/fields.h"
#include "mapping/octree/morton.h"
#include "mapping/octree/slab_pool.h"

namespace atlas::mapping {

enum class BlockKind : uint8_t { kUniform, kCoarse, kFine };

/// One bit a block of a chunk.
struct BlockMask {
  std::array<uint64_t, 8> bits = {};
  bool Test(int block) const { return bits[static_cast<size_t>(block) >> 6] >> (block & 63) & 1; }
  void Set(int block) { bits[static_cast<size_t>(block) >> 6] |= uint64_t{1} << (block & 63); }
  void Clear(int block) { bits[static_cast<size_t>(block) >> 6] &= ~(uint64_t{1} << (block & 63)); }
  bool Any() const {
    uint64_t any = 0;
    for (const uint64_t b : bits) any |= b;
    return any != 0;
  }
};

template <typename Field>
class Octree {
 public:
  using Value = typename Field::Value;
  using Node = typename Field::Node;
  using FineLeaf = typename Field::template Cells<kBlockVoxels>;
  using CoarseLeaf = typename Field::template Cells<64>;

  struct Chunk {
    NodeKey key;
    typename Field::template Cells<kChunkBlocks> uniform;  ///< of uniform blocks; stale for others
    BlockMask fine, coarse;
    /// Where leaves and the summaries of levels 3 to 6 lie; absent while all blocks are uniform.
    struct Detail {
      std::array<uint32_t, kChunkBlocks> leaf;
      std::array<Node, kChunkBlocks> block;
    };
    Detail* detail = nullptr;
    std::array<Node, 64> level4;
    std::array<Node, 8> level5;
    Node level6;
    BlockMask dirty;                     ///< blocks written since TakeChanges
    uint32_t cell = 0, detail_cell = 0;  ///< in the pools

    BlockKind Kind(int block) const {
      return fine.Test(block)     ? BlockKind::kFine
             : coarse.Test(block) ? BlockKind::kCoarse
                                  : BlockKind::kUniform;
    }
    /// The summary of a block, current after Propagate.
    Node BlockNode(int block) const {
      return Kind(block) == BlockKind::kUniform ? Field::NodeOf(uniform.Get(block))
                                                : detail->block[static_cast<size_t>(block)];
    }
  };

  /// @throws std::invalid_argument unless 0.001 <= resolution_m <= 10.
  explicit Octree(double resolution_m);
  Octree(Octree&&) noexcept;
  Octree& operator=(Octree&&) noexcept;
  ~Octree();

  /// A copy that shares nothing; nothing of it is marked dirty.
  Octree Clone() const;

  double resolution_m() const { return resolution_m_; }
  NodeKey KeyAt(const core::Vec3& p) const { return VoxelKeyAt(p, inverse_resolution_); }
  core::Vec3 CenterOf(const NodeKey& voxel) const {
    return resolution_m_ * (core::Vec3(voxel.x, voxel.y, voxel.z).array() + 0.5);
  }

  // --- Structure
  const Chunk* Find(const NodeKey& chunk) const { return chunks_.Find(chunk); }
  Chunk* Find(const NodeKey& chunk) { return chunks_.Find(chunk); }
  Chunk* FindOrCreate(const NodeKey& chunk);
  void Erase(const NodeKey& chunk, int worker = 0);
  size_t chunk_count() const { return chunks_.size(); }
  /// All chunks by ascending Morton code.
  std::vector<const Chunk*> Chunks() const;

  // --- Voxels
  /// The value that holds for a voxel, at whatever scale it is stored; unknown where nothing is.
  Value At(const NodeKey& voxel) const;
  Value At(const core::Vec3& p) const { return At(KeyAt(p)); }
  /// Of the voxel of that VoxelIndex in a block.
  Value ValueIn(const Chunk& chunk, int block, int index) const {
    switch (chunk.Kind(block)) {
      case BlockKind::kUniform:
        return chunk.uniform.Get(block);
      case BlockKind::kCoarse:
        return Coarse(chunk, block).Get(CellOfVoxel(index));
      case BlockKind::kFine:
        break;
    }
    return Fine(chunk, block).Get(index);
  }
  /// Writes one voxel, splitting its block. Slow path for tests and loaders; mend summaries with Propagate.
  void Set(const NodeKey& voxel, Value value, int worker = 0);

  // --- Blocks
  FineLeaf& Fine(Chunk* chunk, int block) {
    return (*fine_)[chunk->detail->leaf[static_cast<size_t>(block)]];
  }
  const FineLeaf& Fine(const Chunk& chunk, int block) const {
    return (*fine_)[chunk.detail->leaf[static_cast<size_t>(block)]];
  }
  CoarseLeaf& Coarse(Chunk* chunk, int block) {
    return (*coarse_)[chunk->detail->leaf[static_cast<size_t>(block)]];
  }
  const CoarseLeaf& Coarse(const Chunk& chunk, int block) const {
    return (*coarse_)[chunk.detail->leaf[static_cast<size_t>(block)]];
  }
  /// Splits a block down to that kind, keeping every voxel's value. @pre for MakeCoarse: it is not fine.
  CoarseLeaf& MakeCoarse(Chunk* chunk, int block, int worker);
  FineLeaf& MakeFine(Chunk* chunk, int block, int worker);
  /// Makes a block uniform, giving its leaf back.
  void MakeUniform(Chunk* chunk, int block, Value value, int worker);
  /// A block's 512 values, whatever its kind.
  void Expand(const Chunk& chunk, int block, FineLeaf* out) const;

  /// Recomputes the summaries of the blocks in `which` and of all nodes above them in the chunk.
  void Propagate(Chunk* chunk, const BlockMask& which);
  /// The nodes above those blocks alone, for callers that keep Detail::block current themselves.
  void PropagateAbove(Chunk* chunk, const BlockMask& which);
  /// Makes uniform what holds one value throughout (lossless). Call before Propagate.
  void CollapseEqual(Chunk* chunk, const BlockMask& which, int worker);
  /// The chunks with dirty blocks, by ascending code, as (key, mask); clears the marks.
  std::vector<std::pair<NodeKey, BlockMask>> TakeChanges();

  /// Room for that many workers in the leaf pools.
  void SetWorkers(int workers);

  /// Bytes of chunks and leaves in use, tables included.
  size_t Bytes() const;
  struct Counts {
    size_t chunks = 0, fine = 0, coarse = 0;
    size_t uniform_known = 0;  ///< uniform blocks that hold a known value
  };
  Counts Count() const;

 private:
  typename Chunk::Detail* DetailOf(Chunk* chunk, int worker);

  // Out of pools, since a general allocator may take milliseconds for a chunk where others left it in pieces.
  static constexpr uint32_t kChunkSlabBits = 8;
  using ChunkPool = SlabPool<Chunk, kChunkSlabBits>;
  using DetailPool = SlabPool<typename Chunk::Detail, kChunkSlabBits>;

  double resolution_m_, inverse_resolution_;
  ChunkTable<Chunk> chunks_;
  std::unique_ptr<ChunkPool> chunk_pool_;
  std::unique_ptr<DetailPool> details_;
  std::unique_ptr<SlabPool<FineLeaf>> fine_;
  std::unique_ptr<SlabPool<CoarseLeaf>> coarse_;
};

using OccupancyOctree = Octree<OccupancyField>;
using TsdfOctree = Octree<TsdfField>;

extern template class Octree<OccupancyField>;
extern template class Octree<TsdfField>;

}  // namespace atlas::mapping
