// Writes evidence into the blocks of one chunk: splits blocks where it must, collapses what became uniform
// and keeps summaries and change marks. One for each field, with the same face.
#pragma once

#include <cstdint>

#include "mapping/integrator/write/occupancy_apply.h"
#include "mapping/integrator/write/tsdf_apply.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// What a scan adds where it saw nothing but free space, and how blocks collapse.
struct WriteRules {
  int miss_units = 8;            ///< occupancy
  int hit_units = 16;            ///< occupancy: least of a voxel that holds a return
  int edge_units = 4;            ///< occupancy: of a free voxel beside a surface
  int16_t free_distance = 4096;  ///< TSDF
  bool lossless = false;
};

template <typename Field>
class BlockWriter;

template <>
class BlockWriter<OccupancyField> {
 public:
  using Evidence = int8_t;  ///< a voxel each; 0 none
  BlockWriter(const WriteRules& rules, int worker, OccupancyOctree* map, OccupancyOctree::Chunk* chunk)
      : rules_(rules), worker_(worker), map_(map), chunk_(chunk) {}

  /// A miss of whole uniform blocks: bits of 64 blocks from 64 * word.
  void FreeUniform(size_t word, uint64_t blocks) {
    changed_.bits[word] |= ApplyMiss(chunk_->uniform.log_odds + 64 * word, blocks, rules_.miss_units);
  }
  /// A miss of cells of 2^3. @pre the block is not fine.
  void FreeCoarse(int block, uint64_t cells) {
    int8_t* values = map_->MakeCoarse(chunk_, block, worker_).log_odds;
    Finish(block, ApplyEvidence(values, 1, &cells, {}, nullptr, rules_.miss_units, rules_.hit_units));
  }
  /// A miss of voxels (null for all), overruled by evidence
  /// where there is some (null for none).
  void UpdateFine(int block, const uint64_t* free, const WeakMisses& weak, const Evidence* evidence) {
    int8_t* values = map_->MakeFine(chunk_, block, worker_).log_odds;
    Finish(block, ApplyEvidence(values, 8, free, weak, evidence, rules_.miss_units, rules_.hit_units));
  }
  /// Brings the chunk's summaries up to date and marks what changed.
  void Close() {
    map_->PropagateAbove(chunk_, changed_);
    for (size_t word = 0; word < 8; ++word) chunk_->dirty.bits[word] |= changed_.bits[word];
  }

 private:
  void Finish(int block, const ApplyResult& result) {
    if (result.changed) changed_.Set(block);
    const bool known = !result.node.any_unknown;
    const bool equal = known && result.min == result.node.max;
    if (equal || (known && result.node.max < 0 && !rules_.lossless)) {
      map_->MakeUniform(chunk_, block, result.node.max, worker_);
      changed_.Set(block);
    } else {
      chunk_->detail->block[static_cast<size_t>(block)] = result.node;
    }
  }

  const WriteRules rules_;
  const int worker_;
  OccupancyOctree* const map_;
  OccupancyOctree::Chunk* const chunk_;
  BlockMask changed_;
};

template <>
class BlockWriter<TsdfField> {
 public:
  using Evidence = int16_t;  ///< a voxel each; kNoDistance none
  BlockWriter(const WriteRules& rules, int worker, TsdfOctree* map, TsdfOctree::Chunk* chunk)
      : rules_(rules), worker_(worker), map_(map), chunk_(chunk) {}

  void FreeUniform(size_t word, uint64_t blocks) {
    const auto before = chunk_->uniform;
    ApplyDistances(chunk_->uniform.distance + 64 * word, chunk_->uniform.weight + 64 * word, 1, &blocks,
                   nullptr, rules_.free_distance);
    for (uint64_t bits = blocks; bits != 0; bits &= bits - 1) {
      const int block = static_cast<int>(64 * word) + __builtin_ctzll(bits);
      if (!(before.Get(block) == chunk_->uniform.Get(block))) changed_.Set(block);
    }
  }
  void FreeCoarse(int block, uint64_t cells) { UpdateCoarse(block, cells, nullptr); }
  /// Of cells of 2^3. @pre the block is not fine.
  void UpdateCoarse(int block, uint64_t cells, const Evidence* evidence) {
    auto& leaf = map_->MakeCoarse(chunk_, block, worker_);
    Finish(block, ApplyDistances(leaf.distance, leaf.weight, 1, &cells, evidence, rules_.free_distance),
           leaf);
  }
  void UpdateFine(int block, const uint64_t* free, const WeakMisses&, const Evidence* evidence) {
    const bool split = chunk_->coarse.Test(block);
    auto& leaf = map_->MakeFine(chunk_, block, worker_);
    // A cell's distance is a poor guess of its voxels': the first of their own counts as much.
    if (split) {
      for (uint8_t& weight : leaf.weight) weight = std::min<uint8_t>(weight, 1);
    }
    Finish(block, ApplyDistances(leaf.distance, leaf.weight, 8, free, evidence, rules_.free_distance), leaf);
  }
  void Close() {
    map_->PropagateAbove(chunk_, changed_);
    for (size_t word = 0; word < 8; ++word) chunk_->dirty.bits[word] |= changed_.bits[word];
  }

 private:
  /// Collapses what is equal; else, unless lossless, what is free at the full distance throughout, keeping
  /// the least weight.
  template <typename Leaf>
  void Finish(int block, bool changed, const Leaf& leaf) {
    if (changed) changed_.Set(block);
    const TsdfField::Summary s = TsdfField::Summarise(leaf);
    const bool equal = s.lightest == s.heaviest && s.least == s.greatest && s.lightest > 0;
    const bool free = s.lightest > 0 && s.least >= rules_.free_distance && !rules_.lossless;
    if (equal || free) {
      map_->MakeUniform(chunk_, block, {s.least, s.lightest}, worker_);
      changed_.Set(block);
    } else {
      chunk_->detail->block[static_cast<size_t>(block)] = s.node;
    }
  }

  const WriteRules rules_;
  const int worker_;
  TsdfOctree* const map_;
  TsdfOctree::Chunk* const chunk_;
  BlockMask changed_;
};

}  // namespace atlas::mapping
