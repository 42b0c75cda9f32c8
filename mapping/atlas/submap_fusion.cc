#include "mapping/atlas/submap_fusion.h"

#include <algorithm>
#include <array>
#include <map>

#include "mapping/atlas/block_window.h"
#include "mapping/atlas/distance_fusion.h"
#include "mapping/atlas/distance_states.h"
#include "mapping/atlas/submap_outline.h"
#include "mapping/integrator/write/occupancy_shift.h"
#include "mapping/octree/queries.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using Field = OccupancyField;
using Chunk = OccupancyOctree::Chunk;

constexpr int kPlaceBits = Field::kPlaces - 1;

int BaseOf(int8_t v) {
  return v > 0 ? v & ~kPlaceBits : v;
}

/// Positive in front of the surface; both clamps count alike, since free evidence is cut off earlier.
double FrontOf(int8_t v) {
  return v == Field::kMin ? 1.0 : -static_cast<double>(v) / Field::kMax;
}

NodeKey Shifted(NodeKey key, int axis, int by) {
  (axis == 0 ? key.x : axis == 1 ? key.y : key.z) += by;
  return key;
}

/// A submap read at the places of another's voxels.
class Resampler {
 public:
  Resampler(const OccupancyOctree& from, const Pose& T_from_to)
      : from_(from), T_from_to_(T_from_to), inverse_(1.0 / from.resolution_m()), window_(from) {}

  /// To the blocks that meet a block of the other submap.
  const BlockWindow& MoveTo(const Vec3& center_to, double block_m) {
    const Vec3 center = T_from_to_ * center_to, half = HalfSizeOfTurned(block_m, T_from_to_);
    window_.MoveTo(from_.KeyAt(center - half).Up(kBlockLevel), from_.KeyAt(center + half).Up(kBlockLevel));
    return window_;
  }
  /// What the voxel around a point holds, a surface's place in it told for the asking voxel around the point.
  /// @pre the point lies in the block moved to last
  int8_t At(const Vec3& p_to) {
    const Vec3 p_from = T_from_to_ * p_to;
    const NodeKey voxel = from_.KeyAt(p_from);
    const int8_t held = window_.At(voxel);
    return Field::Occupied(held) ? Replaced(held, voxel, p_from) : held;
  }
  /// @pre as above
  int8_t Plain(const Vec3& p_to) const { return window_.At(from_.KeyAt(T_from_to_ * p_to)); }

 private:
  /// The surface keeps its place along its normal n: it lies support (2 place - 1) in front of the middle of
  /// the voxel that held it, and as told by the new place before the middle of the one that does now.
  int8_t Replaced(int8_t held, const NodeKey& voxel, const Vec3& p_from) {
    Vec3 inwards;
    for (int axis = 0; axis < 3; ++axis) {
      const int8_t low = window_.AtAny(Shifted(voxel, axis, -1)),
                   high = window_.AtAny(Shifted(voxel, axis, 1));
      inwards[axis] = FrontOf(Field::Known(low) ? low : held) - FrontOf(Field::Known(high) ? high : held);
    }
    const double length = inwards.norm();
    if (!(length > 0.0)) return held;
    inwards /= length;
    const double support = OccupancyShift(inwards, 1.0),
                 new_support = OccupancyShift(T_from_to_.linear().transpose() * inwards, 1.0),
                 moved = inverse_ * inwards.dot(p_from - from_.CenterOf(voxel));
    const double behind = 0.5 + 0.5 * (moved + support * (2.0 * Field::PlaceOf(held) - 1.0)) / new_support;
    const int place = std::clamp(static_cast<int>(std::floor(behind * Field::kPlaces)), 0, kPlaceBits);
    return static_cast<int8_t>(BaseOf(held) | place);
  }

  const OccupancyOctree& from_;
  const Pose T_from_to_;
  const double inverse_;
  BlockWindow window_;
};

using Reached = std::map<uint64_t, BlockMask>;  ///< blocks by the codes of their chunks

/// Blocks of `to` that meet known blocks of `from`.
Reached BlocksReached(const SubmapOutline& from, const Pose& T_to_from, const OccupancyOctree& to) {
  Reached reached;
  // Neighbouring blocks reach the same few chunks.
  struct Recent {
    NodeKey chunk;
    BlockMask* blocks = nullptr;
  };
  std::array<Recent, 8> recent;
  const auto set = [&](const NodeKey& block) {
    const NodeKey chunk = block.Up(kBlockLevel);
    Recent& slot = recent[static_cast<size_t>((chunk.x & 1) | (chunk.y & 1) << 1 | (chunk.z & 1) << 2)];
    if (slot.blocks == nullptr || !(slot.chunk == chunk)) slot = {chunk, &reached[ChunkCode(chunk)]};
    slot.blocks->Set(BlockIndex(block.x, block.y, block.z));
  };
  const Vec3 half = HalfSizeOfTurned(from.block_m, T_to_from);
  from.ForEachBlock([&](const Vec3& center_from) {
    const Vec3 center = T_to_from * center_from;
    const NodeKey low = to.KeyAt(center - half).Up(kBlockLevel),
                  high = to.KeyAt(center + half).Up(kBlockLevel);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) set({x, y, z});
      }
    }
  });
  return reached;
}

/// Fuses block by block of one chunk of `to`.
class ChunkFusion {
 public:
  ChunkFusion(Resampler* from, FusionRule rule, OccupancyOctree* to, Chunk* chunk)
      : from_(*from), rule_(rule), to_(*to), chunk_(chunk) {}

  void Fuse(int block) {
    const NodeKey offset = BlockOffset(block);
    const NodeKey first{8 * (8 * chunk_->key.x + offset.x), 8 * (8 * chunk_->key.y + offset.y),
                        8 * (8 * chunk_->key.z + offset.z)};
    const double resolution_m = to_.resolution_m();
    const Vec3 low = resolution_m * Vec3(first.x, first.y, first.z);
    const BlockWindow& around = from_.MoveTo(low.array() + 4.0 * resolution_m, kBlockSide * resolution_m);
    if (around.one_value() && !Field::Known(around.value())) return;
    const BlockKind kind = chunk_->Kind(block);
    if (around.one_value() && kind == BlockKind::kUniform) {
      to_.MakeUniform(chunk_, block, Fused(chunk_->uniform.Get(block), around.value()), 0);
    } else if (around.finest() == BlockKind::kFine || kind == BlockKind::kFine) {
      Cells<kBlockVoxels>(block, &to_.MakeFine(chunk_, block, 0), [&](int i) {
        return from_.At(low + resolution_m * Vec3((i & 7) + 0.5, (i >> 3 & 7) + 0.5, (i >> 6) + 0.5));
      });
    } else {
      Cells<64>(block, &to_.MakeCoarse(chunk_, block, 0), [&](int i) {
        return from_.Plain(low +
                           2.0 * resolution_m * Vec3((i & 3) + 0.5, (i >> 2 & 3) + 0.5, (i >> 4) + 0.5));
      });
    }
    chunk_->dirty.Set(block);
  }

 private:
  /// Leaves that are free throughout, or equal, become uniform as when scans are integrated.
  template <int N, typename Leaf, typename Sample>
  void Cells(int block, Leaf* leaf, const Sample& sample) {
    int least = Field::kMax + 1, greatest = Field::kMin - 1;
    bool known = true;
    for (int i = 0; i < N; ++i) {
      const int8_t value = Fused(leaf->Get(i), sample(i));
      leaf->Set(i, value);
      known = known && Field::Known(value);
      least = std::min<int>(least, value);
      greatest = std::max<int>(greatest, value);
    }
    if (least == greatest || (known && greatest < 0))
      to_.MakeUniform(chunk_, block, static_cast<int8_t>(greatest), 0);
  }

  int8_t Fused(int8_t held, int8_t added) const {
    return rule_ == FusionRule::kFirst && Field::Known(held) ? held : FusedValue(held, added);
  }

  Resampler& from_;
  const FusionRule rule_;
  OccupancyOctree& to_;
  Chunk* const chunk_;
};

/// A voxel turned against a lattice may hold none of its middles. What is occupied and so was not asked for
/// goes to the voxel that its own middle falls in.
void SendUnasked(const OccupancyOctree& from, const Pose& T_to_from, FusionRule rule, OccupancyOctree* to) {
  const Pose T_from_to = T_to_from.inverse();
  ForEachCell(from, [&](const NodeKey& voxel, int level, int8_t value) {
    if (level != 0 || !Field::Occupied(value)) return;
    const NodeKey at = to->KeyAt(T_to_from * from.CenterOf(voxel));
    for (int i = 0; i < 27; ++i) {
      const int n = (i + 13) % 27;  // the one in the middle first
      const NodeKey near{at.x + n % 3 - 1, at.y + n / 3 % 3 - 1, at.z + n / 9 - 1};
      if (from.KeyAt(T_from_to * to->CenterOf(near)) == voxel) return;
    }
    const int8_t held = to->At(at);
    if (rule == FusionRule::kAdd || !Field::Known(held)) to->Set(at, FusedValue(held, value));
  });
}

void FuseEvidence(const OccupancyOctree& from, const Pose& T_to_from, FusionRule rule, const Reached& reached,
                  OccupancyOctree* to) {
  Resampler resampler(from, T_to_from.inverse());
  for (const auto& [code, blocks] : reached) {
    ChunkFusion fusion(&resampler, rule, to, to->FindOrCreate(ChunkKeyOf(code)));
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (blocks.Test(block)) fusion.Fuse(block);
    }
  }
  SendUnasked(from, T_to_from, rule, to);
  for (const auto& [code, blocks] : reached) {
    Chunk* const chunk = to->Find(ChunkKeyOf(code));
    to->Propagate(chunk, blocks);
    if (!Field::NodeObserved(chunk->level6)) to->Erase(chunk->key);
  }
}

}  // namespace

int8_t FusedValue(int8_t a, int8_t b) {
  if (!Field::Known(a)) return b;
  if (!Field::Known(b)) return a;
  const int sum = std::clamp(BaseOf(a) + BaseOf(b), Field::kMin, Field::kMax & ~kPlaceBits);
  if (sum < 0) return static_cast<int8_t>(sum);
  int place = (a > 0 ? a : b > 0 ? b : 0) & kPlaceBits;
  if (a > 0 && b > 0) {
    const int of_a = BaseOf(a) + 1, of_b = BaseOf(b) + 1, all = of_a + of_b;
    place = (2 * (of_a * (a & kPlaceBits) + of_b * (b & kPlaceBits)) + all) / (2 * all);
  }
  return static_cast<int8_t>(std::max(1, (sum & ~kPlaceBits) | place));  // 1: evidence that cancels
}

void FuseInto(const OctreeContents& from, const Pose& T_to_from, FusionRule rule, OctreeContents* to) {
  const Reached reached = BlocksReached(OutlineOf(from), T_to_from, to->tree);
  if (from.distances && to->distances) {
    FuseDistances(*from.distances, T_to_from, reached, &*to->distances);
    for (const auto& [code, blocks] : reached)
      TellStates(*to->distances, ChunkKeyOf(code), blocks, &to->tree);
  } else {
    FuseEvidence(from.tree, T_to_from, rule, reached, &to->tree);
  }
  if (from.behind && to->behind) to->behind->Merge(*from.behind, T_to_from);
}

}  // namespace atlas::mapping
