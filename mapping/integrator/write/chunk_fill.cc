#include <cstring>

#include "mapping/integrator/free_space/voxel_bits.h"
#include "mapping/integrator/write/block_writer.h"
#include "mapping/integrator/write/chunk_fill.h"

namespace atlas::mapping {
namespace {

/// Evidence on surfaces in one block: Eq. 4.2's updates, scattered beforehand.
class OccupancyEvidence {
 public:
  OccupancyEvidence(const FillContext& context, const ChunkWork& work)
      : context_(context), index_(work.index) {
    const BlockMask* touched = context.hits->Touched(work.index);
    if (touched != nullptr) touched_ = *touched;
  }
  /// Blocks that may bear evidence though no beam passes freely.
  uint64_t Candidates(size_t word) const { return touched_.bits[word]; }
  const int8_t* Of(int block, const NodeKey&, int) {
    return touched_.Test(block) ? context_.hits->Block(index_, block).delta : nullptr;
  }

 private:
  const FillContext& context_;
  const size_t index_;
  BlockMask touched_;
};

/// Distances to the planes of the nearest beams, measured voxel by voxel.
class TsdfEvidence {
 public:
  TsdfEvidence(const FillContext& context, const ChunkWork& work)
      : context_(context), mixed_(work.blocks.mixed) {}
  uint64_t Candidates(size_t) const { return 0; }
  const int16_t* Of(int block, const NodeKey& corner, int scale) {
    if (!mixed_.Test(block)) return nullptr;
    const bool any = MeasureDistances(*context_.surface, *context_.frame, corner,
                                      context_.truncation_m * static_cast<float>(scale),
                                      context_.distance_unit_m, measured_);
    return any ? measured_ : nullptr;
  }
  /// Of cells of 2^3.
  const int16_t* OfCells(const NodeKey& corner, int scale) {
    const bool any = MeasureCellDistances(*context_.surface, *context_.frame, corner,
                                          context_.truncation_m * static_cast<float>(scale),
                                          context_.distance_unit_m, measured_);
    return any ? measured_ : nullptr;
  }

 private:
  const FillContext& context_;
  const BlockMask& mixed_;
  alignas(64) int16_t measured_[kBlockVoxels];
};

template <typename Field>
struct EvidenceOf;
template <>
struct EvidenceOf<OccupancyField> {
  using Type = OccupancyEvidence;
};
template <>
struct EvidenceOf<TsdfField> {
  using Type = TsdfEvidence;
};

template <typename Field>
class Filler {
 public:
  using Chunk = typename Octree<Field>::Chunk;
  using Evidence = typename BlockWriter<Field>::Evidence;

  Filler(const FillContext& context, const ChunkWork& work, int worker, Octree<Field>* map, Chunk* chunk)
      : context_(context),
        work_(work),
        chunk_(chunk),
        map_(map),
        writer_(context.rules, worker, map, chunk),
        evidence_(context, work_) {
    corner_ = {work.window.x * kChunkSide, work.window.y * kChunkSide, work.window.z * kChunkSide};
  }

  void Run() {
    if (work_.cut) CutBlocks();
    for (size_t word = 0; word < 8; ++word) {
      if constexpr (std::is_same_v<Field, OccupancyField>) {
        // A partial miss adds nothing to what is free as a whole already.
        if (!context_.rules.lossless) {
          work_.blocks.mixed.bits[word] &= ~FreeAlready(word) | evidence_.Candidates(word);
        }
      }
      const uint64_t full = work_.blocks.full.bits[word], candidates = evidence_.Candidates(word);
      const uint64_t leaves = chunk_->fine.bits[word] | chunk_->coarse.bits[word];
      if (const uint64_t whole = full & ~leaves & ~candidates) writer_.FreeUniform(word, whole);
      ForEach(full & (leaves | candidates), word, [&](int block) { FreeWhole(block); });
      ForEach((work_.blocks.mixed.bits[word] | candidates) & ~full, word,
              [&](int block) { FillMixed(block); });
    }
    writer_.Close();
  }

 private:
  template <typename Visit>
  void ForEach(uint64_t bits, size_t word, const Visit& visit) {
    const int first = static_cast<int>(64 * word);
    for (; bits != 0; bits &= bits - 1) {
      const int block = first + __builtin_ctzll(bits);
      const uint64_t rest = bits & (bits - 1);
      next_ = rest == 0 ? block : first + __builtin_ctzll(rest);
      visit(block);
    }
  }

  NodeKey CornerOf(int block) const {
    const NodeKey b = BlockOffset(block);
    return {corner_.x + 8 * b.x, corner_.y + 8 * b.y, corner_.z + 8 * b.z};
  }

  /// Blocks outside what is kept are dropped; those on its border are decided voxel by voxel.
  void CutBlocks() {
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (Inside(block)) continue;
      VoxelBits all;
      all.layer.fill(~uint64_t{0});
      Keep(block, &all);
      uint64_t any = 0;
      for (const uint64_t layer : all.layer) any |= layer;
      const bool reached = work_.blocks.mixed.Test(block) || work_.blocks.full.Test(block);
      work_.blocks.full.Clear(block);
      work_.blocks.mixed.Clear(block);
      if (any != 0 && reached) work_.blocks.mixed.Set(block);
    }
  }

  void FreeWhole(int block) {
    const Evidence* evidence = evidence_.Of(block, CornerOf(block), 1);
    if (chunk_->coarse.Test(block) && evidence == nullptr) {
      writer_.FreeCoarse(block, ~uint64_t{0});
    } else {
      writer_.UpdateFine(block, nullptr, {}, evidence);
    }
  }

  /// The uniform blocks that are free.
  uint64_t FreeAlready(size_t word) const {
    uint64_t free = 0;
    for (size_t i = 0; i < 8; ++i) {
      uint64_t values;
      std::memcpy(&values, chunk_->uniform.log_odds + 64 * word + 8 * i, sizeof values);
      free |= ((values & 0x8080808080808080u) * 0x0002040810204081u >> 56) << (8 * i);
    }
    return free & ~(chunk_->fine.bits[word] | chunk_->coarse.bits[word]);
  }

  void FillMixed(int block) {
    if (chunk_->fine.Test(next_)) {
      const char* leaf = reinterpret_cast<const char*>(&map_->Fine(*chunk_, next_));
      for (size_t i = 0; i < sizeof(typename Octree<Field>::FineLeaf); i += 64) __builtin_prefetch(leaf + i);
    }
    const bool inside = Inside(block);
    const int cone = ScaleAt(block);
    if constexpr (std::is_same_v<Field, TsdfField>) {
      if (inside && cone > 1 && !chunk_->fine.Test(block)) return FillCells(block, cone);
    }
    const Evidence* evidence = evidence_.Of(block, CornerOf(block), cone);
    const bool uniform = chunk_->Kind(block) == BlockKind::kUniform;
    if (!context_.rules.lossless && uniform && evidence == nullptr &&
        Field::Free(chunk_->uniform.Get(block))) {
      return;  // a partial miss adds nothing to what is free as a whole already
    }
    const bool mixed = work_.blocks.mixed.Test(block);
    const bool by_voxel = !inside || cone == 1 || HoldsSurface(block);
    if (mixed && !by_voxel && evidence == nullptr && !chunk_->fine.Test(block)) {
      return FillCoarse(block, FreeCells(block, cone));
    }
    VoxelBits free{};
    if (mixed) free = by_voxel ? FreeVoxels(block) : ToVoxels(FreeCells(block, cone));
    if (!inside) {
      Keep(block, &free);
      if (evidence != nullptr) evidence = Keep(block, evidence);
    }
    // Occupied voxels beside others that are not free lose less; where beams are several voxels apart,
    // they are not updated: who skims a crest from afar sees it free again and again, and never hits it.
    if (std::is_same_v<Field, OccupancyField> && mixed && (evidence != nullptr || HoldsSurface(block))) {
      const VoxelBits edge = EdgeOf(free);
      const bool near = cone == 1;
      Apply(
          block, free,
          {edge.layer.data(), near ? context_.rules.edge_units : 0, near ? 0 : OccupancyField::kNoneObserved},
          evidence);
    } else {
      Apply(block, free, {}, evidence);
    }
  }

  /// Distances where beams are voxels apart: in cells, until a nearer scan splits the block.
  void FillCells(int block, int cone) {
    const Evidence* evidence = evidence_.OfCells(CornerOf(block), cone);
    const bool uniform = chunk_->Kind(block) == BlockKind::kUniform;
    if (!context_.rules.lossless && uniform && evidence == nullptr && Field::Free(chunk_->uniform.Get(block)))
      return;  // as in FillMixed
    const uint64_t free = FreeCells(block, cone);
    if (evidence == nullptr) {
      FillCoarse(block, free);
    } else {
      writer_.UpdateCoarse(block, free, evidence);
    }
  }

  /// Free cells of 2 or 4 voxels.
  void FillCoarse(int block, uint64_t cells) {
    if (cells == 0) return;
    if (~cells == 0 && chunk_->Kind(block) == BlockKind::kUniform) {
      FreeUniform(block);
    } else {
      writer_.FreeCoarse(block, cells);
    }
  }

  /// In cells of 2^3, whatever the scale.
  uint64_t FreeCells(int block, int scale) {
    if (scale == 4) {
      if (block != wide_[0] && block != wide_[1]) {
        // Two blocks a call: one fills half of a 16-lane group.
        wide_[0] = block;
        wide_[1] = NextOf(work_.blocks.four_apart, block);
        const NodeKey corners[2] = {CornerOf(block), CornerOf(wide_[1])};
        wide_cells_ = TestWideCells(*context_.tables, *context_.frame, corners);
      }
      return ToCells(wide_cells_ >> (block == wide_[0] ? 0 : 8) & 0xff);
    }
    if ((block >> 6) != slopes_word_ || (slopes_of_ >> (block & 63) & 1) == 0) FindSlopes(block);
    const auto lane =
        static_cast<size_t>(__builtin_popcountll(slopes_of_ & ((uint64_t{1} << (block & 63)) - 1)));
    return TestCells(*context_.tables, *context_.frame, CornerOf(block),
                     smooth_ >> lane & 1 ? &slopes_ : nullptr, lane);
  }

  /// Of a block and up to 15 of its kind after it in its word.
  void FindSlopes(int block) {
    const auto word = static_cast<size_t>(block >> 6);
    uint64_t rest = work_.blocks.mixed.bits[word] & work_.blocks.two_apart.bits[word] &
                    ~work_.blocks.four_apart.bits[word] & ~uint64_t{0} << (block & 63);
    rest |= uint64_t{1} << (block & 63);
    NodeKey corners[16];
    size_t count = 0;
    slopes_word_ = block >> 6;
    slopes_of_ = 0;
    for (; rest != 0 && count < 16; rest &= rest - 1) {
      slopes_of_ |= rest & -rest;
      corners[count++] = CornerOf(static_cast<int>(64 * word) + __builtin_ctzll(rest));
    }
    smooth_ = FindBlockSlopes(*context_.tables, *context_.frame, corners, count, &slopes_);
  }

  /// The mixed block of `kind` after this one in its word; itself where there is none.
  int NextOf(const BlockMask& kind, int block) const {
    const auto word = static_cast<size_t>(block >> 6);
    const uint64_t after = ~uint64_t{1} << (block & 63);
    const uint64_t rest = work_.blocks.mixed.bits[word] & kind.bits[word] & after;
    return rest == 0 ? block : static_cast<int>(64 * word) + __builtin_ctzll(rest);
  }

  /// Octants are tested as a whole first; those that are as free as can be need no test.
  VoxelBits FreeVoxels(int block) {
    const NodeKey corner = CornerOf(block);
    if (block != tested_[0] && block != tested_[1]) {
      // With those of the block that most likely comes next, since twice as many cost the same.
      tested_[0] = block;
      tested_[1] = next_;
      const NodeKey corners[2] = {corner, CornerOf(next_)};
      TestOctants(*context_.tables, *context_.frame, corners, &octants_);
    }
    const int first = block == tested_[0] ? 0 : 8;
    uint32_t full = octants_.cubes.full >> first & 0xff;
    if constexpr (std::is_same_v<Field, OccupancyField>) {
      if (chunk_->fine.Test(block)) full |= SaturatedOctants(map_->Fine(*chunk_, block).log_odds);
    }
    VoxelBits free = ToVoxels(ToCells(full));
    const uint32_t mixed = octants_.cubes.mixed >> first & 0xff & ~full;
    if (mixed != 0) TestVoxels(*context_.tables, *context_.frame, corner, octants_, first, mixed, &free);
    return free;
  }

  void Apply(int block, const VoxelBits& free, const WeakMisses& weak, const Evidence* evidence) {
    uint64_t any = 0, all = ~uint64_t{0};
    for (const uint64_t layer : free.layer) {
      any |= layer;
      all &= layer;
    }
    if (any == 0 && evidence == nullptr) return;
    if (~all == 0 && chunk_->Kind(block) == BlockKind::kUniform && evidence == nullptr) {
      FreeUniform(block);
    } else {
      writer_.UpdateFine(block, free.layer.data(), weak, evidence);
    }
  }

  void FreeUniform(int block) {
    writer_.FreeUniform(static_cast<size_t>(block >> 6), uint64_t{1} << (block & 63));
  }

  bool HoldsSurface(int block) const {
    if (!chunk_->fine.Test(block)) return false;
    const typename Field::Node& node = chunk_->detail->block[static_cast<size_t>(block)];
    if constexpr (std::is_same_v<Field, OccupancyField>) {
      return node.max > 0;
    } else {
      return node.min_distance < context_.rules.free_distance;
    }
  }

  /// Thesis 4.5.1: the largest cells that the beams' cone holds at this distance.
  int ScaleAt(int block) const {
    const int apart = work_.blocks.four_apart.Test(block) ? 4 : work_.blocks.two_apart.Test(block) ? 2 : 1;
    return std::min(apart, context_.max_scale);
  }

  bool Inside(int block) const {
    if (!work_.cut) return true;
    const NodeKey c = CornerOf(block), &a = context_.keep_min, &b = context_.keep_max;
    return c.x >= a.x && c.y >= a.y && c.z >= a.z && c.x + 8 <= b.x && c.y + 8 <= b.y && c.z + 8 <= b.z;
  }
  void Keep(int block, VoxelBits* cells) const {
    const NodeKey c = CornerOf(block), &a = context_.keep_min, &b = context_.keep_max;
    const uint64_t x = KeptAlong(c.x, a.x, b.x), y = KeptAlong(c.y, a.y, b.y), z = KeptAlong(c.z, a.z, b.z);
    uint64_t layer = 0;
    for (int row = 0; row < 8; ++row) layer |= (y >> row & 1) * (x << (8 * row));
    for (size_t i = 0; i < 8; ++i) cells->layer[i] &= (z >> i & 1) * layer;
  }
  const Evidence* Keep(int block, const Evidence* evidence) {
    constexpr Evidence kNone = std::is_same_v<Field, OccupancyField> ? Evidence{0} : Evidence(kNoDistance);
    VoxelBits kept;
    kept.layer.fill(~uint64_t{0});
    Keep(block, &kept);
    bool any = false;
    for (size_t i = 0; i < kBlockVoxels; ++i) {
      const bool in = kept.layer[i >> 6] >> (i & 63) & 1;
      kept_evidence_[i] = in ? evidence[i] : kNone;
      any = any || kept_evidence_[i] != kNone;
    }
    return any ? kept_evidence_ : nullptr;
  }

  const FillContext& context_;
  ChunkWork work_;
  Chunk* const chunk_;
  const Octree<Field>* const map_;
  BlockWriter<Field> writer_;
  typename EvidenceOf<Field>::Type evidence_;
  NodeKey corner_;
  int next_ = 0;              ///< the block after the one at hand
  int tested_[2] = {-1, -1};  ///< the blocks of octants_
  OctantTests octants_;
  int wide_[2] = {-1, -1};  ///< the blocks of wide_cells_
  uint32_t wide_cells_ = 0;
  int slopes_word_ = -1;  ///< the blocks of slopes_: bits of this word of a BlockMask
  uint64_t slopes_of_ = 0;
  uint32_t smooth_ = 0;  ///< lanes of slopes_ that hold
  CubeSlopes slopes_;
  alignas(64) Evidence kept_evidence_[kBlockVoxels];
};

}  // namespace

template <typename Field>
void FillChunk(const FillContext& context, const ChunkWork& work, int worker, Octree<Field>* map,
               typename Octree<Field>::Chunk* chunk) {
  Filler<Field>(context, work, worker, map, chunk).Run();
}

template void FillChunk(const FillContext&, const ChunkWork&, int, OccupancyOctree*, OccupancyOctree::Chunk*);
template void FillChunk(const FillContext&, const ChunkWork&, int, TsdfOctree*, TsdfOctree::Chunk*);

}  // namespace atlas::mapping
