#include <cmath>

#include "mapping/integrator/chunk_fill.h"
#include "mapping/integrator/occupancy_apply.h"

namespace atlas::mapping {
namespace {

using Chunk = OccupancyOctree::Chunk;

/// The 8 voxels along one axis from `corner` that lie in [min, max).
uint32_t KeptAlong(int corner, int min, int max) {
  const int first = std::clamp(min - corner, 0, 8), last = std::clamp(max - corner, 0, 8);
  return first >= last ? 0u : (0xffu >> (8 - (last - first))) << first;
}

/// Bits of the 2^3 cells (of 4^3 cells for scale 4) as bits of voxels.
FreeCells ToVoxels(const FreeCells& cells, int scale) {
  FreeCells out;
  for (int z = 0; z < 8; ++z) {
    uint64_t layer = 0;
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        const int n = 8 / scale;
        const int cell = x / scale + n * (y / scale + n * (z / scale));
        layer |= (cells.voxels[0] >> cell & 1) << (x + 8 * y);
      }
    }
    out.voxels[static_cast<size_t>(z)] = layer;
  }
  return out;
}

/// Bits of 8 cells of 4^3 as bits of 64 cells of 2^3.
uint64_t ToCoarse(uint64_t octants) {
  uint64_t out = 0;
  for (int octant = 0; octant < 8; ++octant) {
    if (octants >> octant & 1) {
      const int x = octant & 1, y = octant >> 1 & 1, z = octant >> 2;
      out |= uint64_t{0x330033} << (2 * x + 8 * y + 32 * z);
    }
  }
  return out;
}

class Filler {
 public:
  Filler(const FillContext& context, const ChunkWork& work, int worker, OccupancyOctree* map, Chunk* chunk)
      : context_(context), work_(work), worker_(worker), map_(map), chunk_(chunk) {
    corner_ = {work.window.x * kChunkSide, work.window.y * kChunkSide, work.window.z * kChunkSide};
    const BlockMask* touched = context.hits->Touched(work.index);
    if (touched != nullptr) touched_ = *touched;
  }

  void Run() {
    if (work_.cut) CutBlocks();
    for (size_t word = 0; word < 8; ++word) {
      const uint64_t full = work_.full.bits[word], touched = touched_.bits[word];
      const uint64_t leaves = chunk_->fine.bits[word] | chunk_->coarse.bits[word];
      if (const uint64_t whole = full & ~leaves & ~touched) {
        changed_.bits[word] |= ApplyMiss(chunk_->uniform.log_odds + 64 * word, whole, context_.miss_units);
      }
      ForEach(full & (leaves | touched), word, [&](int block) { FreeWhole(block); });
      ForEach((work_.mixed.bits[word] | touched) & ~full, word, [&](int block) { FillMixed(block); });
    }
    map_->PropagateAbove(chunk_, changed_);
    for (size_t word = 0; word < 8; ++word) chunk_->dirty.bits[word] |= changed_.bits[word];
  }

 private:
  template <typename Visit>
  static void ForEach(uint64_t bits, size_t word, const Visit& visit) {
    for (; bits != 0; bits &= bits - 1) visit(static_cast<int>(64 * word) + __builtin_ctzll(bits));
  }

  NodeKey CornerOf(int block) const {
    const NodeKey b = BlockOffset(block);
    return {corner_.x + 8 * b.x, corner_.y + 8 * b.y, corner_.z + 8 * b.z};
  }
  const int8_t* Hits(int block) const {
    return touched_.Test(block) ? context_.hits->Block(work_.index, block).delta : nullptr;
  }

  /// Blocks outside what is kept are dropped; those on its border are decided voxel by voxel.
  void CutBlocks() {
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (Inside(block)) continue;
      FreeCells all;
      all.voxels.fill(~uint64_t{0});
      Keep(block, &all);
      uint64_t any = 0;
      for (const uint64_t layer : all.voxels) any |= layer;
      const bool reached = work_.mixed.Test(block) || work_.full.Test(block);
      work_.full.Clear(block);
      work_.mixed.Clear(block);
      if (any != 0 && reached) work_.mixed.Set(block);
    }
  }

  void FreeWhole(int block) {
    const int8_t* hits = Hits(block);
    if (chunk_->coarse.Test(block) && hits == nullptr) {
      UpdateCoarse(block, ~uint64_t{0});
    } else {
      UpdateFine(block, nullptr, hits);
    }
  }

  void FillMixed(int block) {
    const int8_t* hits = Hits(block);
    const bool fine = chunk_->fine.Test(block), coarse = chunk_->coarse.Test(block);
    if (!context_.lossless && !fine && !coarse && hits == nullptr &&
        OccupancyField::Free(chunk_->uniform.Get(block))) {
      return;  // free as a whole already: a partial miss adds nothing
    }
    FreeCells cells{};
    int scale = 1;
    const bool inside = Inside(block);
    if (work_.mixed.Test(block)) {
      const bool surface = fine && chunk_->detail->block[static_cast<size_t>(block)].max > 0;
      scale = surface || !inside ? 1 : ScaleAt(block);
      if (TestCells(*context_.image, *context_.frame, CornerOf(block), scale, &cells) && scale > 1) {
        scale = 1;  // neighbours veto part of the cone: decide voxel by voxel
        TestCells(*context_.image, *context_.frame, CornerOf(block), scale, &cells);
      }
    }
    if (!inside) Keep(block, &cells);
    ApplyCells(block, scale, cells, hits);
  }

  void ApplyCells(int block, int scale, FreeCells cells, const int8_t* hits) {
    const bool fine = chunk_->fine.Test(block), coarse = chunk_->coarse.Test(block);
    if (scale == 4) cells.voxels[0] = ToCoarse(cells.voxels[0]);
    if (scale > 1 && !fine && hits == nullptr) {
      if (cells.voxels[0] == 0) return;
      if (!coarse && ~cells.voxels[0] == 0) {
        FreeUniform(block);
      } else {
        UpdateCoarse(block, cells.voxels[0]);
      }
      return;
    }
    if (scale > 1) cells = ToVoxels(cells, 2);
    uint64_t any = 0, all = ~uint64_t{0};
    for (const uint64_t layer : cells.voxels) {
      any |= layer;
      all &= layer;
    }
    if (any == 0 && hits == nullptr) return;
    if (~all == 0 && !fine && !coarse && hits == nullptr) {
      FreeUniform(block);
    } else {
      UpdateFine(block, cells.voxels.data(), hits);
    }
  }

  void FreeUniform(int block) {
    if (ApplyMiss(chunk_->uniform.log_odds + (block & ~63), uint64_t{1} << (block & 63),
                  context_.miss_units)) {
      changed_.Set(block);
    }
  }

  void UpdateCoarse(int block, uint64_t cells) {
    int8_t* values = map_->MakeCoarse(chunk_, block, worker_).log_odds;
    Finish(block, ApplyEvidence(values, 1, &cells, nullptr, context_.miss_units));
  }
  void UpdateFine(int block, const uint64_t* free, const int8_t* hits) {
    int8_t* values = map_->MakeFine(chunk_, block, worker_).log_odds;
    Finish(block, ApplyEvidence(values, 8, free, hits, context_.miss_units));
  }

  /// Collapses what is free throughout to its least free value (only what is equal, where lossless).
  void Finish(int block, const ApplyResult& result) {
    if (result.changed) changed_.Set(block);
    const bool equal = result.min == result.node.max && !result.node.any_unknown;
    const bool all_free = result.node.max < 0 && !result.node.any_unknown;
    if (equal || (all_free && !context_.lossless)) {
      map_->MakeUniform(chunk_, block, result.node.max, worker_);
      changed_.Set(block);
    } else {
      chunk_->detail->block[static_cast<size_t>(block)] = result.node;
    }
  }

  /// Thesis 4.5.1: the largest cells that the beams' cone holds at this distance.
  int ScaleAt(int block) const {
    const NodeKey corner = CornerOf(block);
    float p[3];
    context_.frame->ToLidar(static_cast<float>(corner.x + 4), static_cast<float>(corner.y + 4),
                            static_cast<float>(corner.z + 4), p);
    const float distance = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    const float cone = distance * static_cast<float>(context_.image->grid->min_pitch_rad);
    const float voxels = cone / context_.frame->resolution_m;
    return std::min(voxels >= 4.0f ? 4 : voxels >= 2.0f ? 2 : 1, context_.max_scale);
  }

  bool Inside(int block) const {
    const NodeKey c = CornerOf(block), &a = context_.keep_min, &b = context_.keep_max;
    return c.x >= a.x && c.y >= a.y && c.z >= a.z && c.x + 8 <= b.x && c.y + 8 <= b.y && c.z + 8 <= b.z;
  }
  void Keep(int block, FreeCells* cells) const {
    const NodeKey c = CornerOf(block), &a = context_.keep_min, &b = context_.keep_max;
    const uint64_t x = KeptAlong(c.x, a.x, b.x), y = KeptAlong(c.y, a.y, b.y), z = KeptAlong(c.z, a.z, b.z);
    uint64_t layer = 0;
    for (int row = 0; row < 8; ++row) layer |= (y >> row & 1) * (x << (8 * row));
    for (size_t i = 0; i < 8; ++i) cells->voxels[i] &= (z >> i & 1) * layer;
  }

  const FillContext& context_;
  ChunkWork work_;
  const int worker_;
  OccupancyOctree* const map_;
  Chunk* const chunk_;
  NodeKey corner_;
  BlockMask touched_, changed_;
};

}  // namespace

template <>
void FillChunk(const FillContext& context, const ChunkWork& work, int worker, OccupancyOctree* map,
               Chunk* chunk) {
  Filler(context, work, worker, map, chunk).Run();
}

}  // namespace atlas::mapping
