#include "mapping/octree/octree_view.h"

#include <cmath>

#include "mapping/octree/ray_walker.h"
#include "mapping/octree/voxel_ray.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = OccupancyField;

/// The chunk of the last voxel asked for.
class ChunkCursor {
 public:
  explicit ChunkCursor(const OccupancyOctree& tree) : tree_(tree) {}
  const OccupancyOctree::Chunk* At(const NodeKey& voxel) {
    const NodeKey key = voxel.Up(kChunkLevel);
    if (!looked_up_ || !(key == key_)) {
      chunk_ = tree_.Find(key);
      key_ = key;
      looked_up_ = true;
    }
    return chunk_;
  }

 private:
  const OccupancyOctree& tree_;
  const OccupancyOctree::Chunk* chunk_ = nullptr;
  NodeKey key_;
  bool looked_up_ = false;
};

}  // namespace

OctreeView::OctreeView(std::shared_ptr<const OctreeContents> contents, const StateLogOdds& states)
    : contents_(std::move(contents)) {
  for (int v = -128; v < 128; ++v) {
    const auto held = static_cast<int8_t>(v);
    const double log_odds = Field::LogOdds(held);
    Value& value = value_[static_cast<uint8_t>(held)];
    value.occupancy = static_cast<float>(1.0 / (1.0 + std::exp(-log_odds)));
    value.state = !Field::Known(held)                  ? CellState::kUnknown
                  : log_odds <= states.free + 1e-9     ? CellState::kFree
                  : log_odds >= states.occupied - 1e-9 ? CellState::kOccupied
                                                       : CellState::kUnknown;
  }
  value_[0].occupancy = 0.5f;
}

int OctreeView::OneStepLevel(const Chunk& chunk, int block, const TraceLimits& limits) const {
  if (!limits.each_free) {
    const auto b = static_cast<size_t>(block);
    if (AllFree(chunk.level6)) return 6;
    if (AllFree(chunk.level5[b >> 6])) return 5;
    if (AllFree(chunk.level4[b >> 3])) return 4;
    if (AllFree(chunk.BlockNode(block))) return 3;
  }
  if (chunk.Kind(block) != BlockKind::kUniform) return -1;
  const int8_t value = chunk.uniform.Get(block);
  const bool one_by_one =
      !Field::Known(value) ? limits.each_unmeasured : ValueAt(value).state != CellState::kFree;
  return one_by_one ? -1 : UniformLevel<Field>(chunk, block);
}

/// A ray on its way through a block, voxel by voxel.
struct OctreeView::Crossing {
  const OctreeView& view;
  uint64_t first_key;  ///< of the block's first voxel
  const BehindSurface::Block* marks;
  VoxelRay* ray;
  RaySamples* met;
  bool* occupied;

  /// @param value_of  log-odds of a voxel by its index in the block. Returns whether the ray goes on.
  template <typename ValueOf>
  bool Through(const ValueOf& value_of) const {
    return ray->CrossVoxels(occupied, [&](int index, double length_m) {
      const Value& value = view.ValueAt(value_of(index));
      const auto i = static_cast<uint64_t>(index);
      const float mark = marks != nullptr && value.occupancy == 0.5f
                             ? static_cast<float>((*marks)[static_cast<size_t>(index)])
                             : 0.0f;
      return met->Add({.occupancy = value.occupancy,
                       .length_m = static_cast<float>(length_m),
                       .key = first_key + ((i & 7) | (i >> 3 & 7) << 21 | (i >> 6) << 42),
                       .behind_surface = mark,
                       .state = value.state});
    });
  }
};

RayEnd OctreeView::Trace(const Vec3& origin_map, const Vec3& direction_map, const TraceLimits& limits,
                         std::vector<RaySample>* samples) const {
  RaySamples met(limits, samples);
  const auto span = limits.box_map.Clip(origin_map, direction_map);
  if (!span || span->first >= limits.max_range_m) return RayEnd::kVoid;
  const OccupancyOctree& tree = contents_->tree;
  VoxelRay ray(origin_map, direction_map, tree.resolution_m(), span->first,
               std::min(span->second, limits.max_range_m), VoxelsOf(limits.box_map, tree.resolution_m()));
  const BehindSurface* const behind =
      limits.behind_surface && contents_->behind ? &*contents_->behind : nullptr;
  ChunkCursor chunks(tree);

  bool occupied = false, on = true;
  while (on) {
    const NodeKey voxel = ray.voxel();
    const Chunk* const chunk = chunks.At(voxel);
    const int block = BlockIndexOf(voxel);
    const BehindSurface::Block* const marks = behind != nullptr ? behind->Find(voxel) : nullptr;

    int level = -1;
    if (chunk != nullptr) {
      level = OneStepLevel(*chunk, block, limits);
    } else if (!limits.each_unmeasured) {
      level = behind != nullptr ? kBlockLevel : kChunkLevel;
    }
    if (level >= 0 && marks == nullptr) {
      const Value& value = ValueAt(chunk != nullptr ? tree.At(voxel) : Field::Unknown());
      uint32_t voxels = 0;
      float length_m = 0.0f;
      on = ray.CrossCube(level, &voxels, &length_m);
      met.Add({.occupancy = value.occupancy,
               .length_m = length_m,
               .key = PackedKey(voxel),
               .voxels = voxels,
               .state = value.state});
      continue;
    }

    const Crossing crossing{
        *this, PackedKey({voxel.x & ~7, voxel.y & ~7, voxel.z & ~7}), marks, &ray, &met, &occupied};
    const BlockKind kind = chunk != nullptr ? chunk->Kind(block) : BlockKind::kUniform;
    if (kind == BlockKind::kFine) {
      const auto& leaf = tree.Fine(*chunk, block);
      on = crossing.Through([&leaf](int index) { return leaf.log_odds[index]; });
    } else if (kind == BlockKind::kCoarse) {
      const auto& leaf = tree.Coarse(*chunk, block);
      on = crossing.Through([&leaf](int index) { return leaf.log_odds[CellOfVoxel(index)]; });
    } else {
      const int8_t value = chunk != nullptr ? chunk->uniform.Get(block) : Field::Unknown();
      on = crossing.Through([value](int) { return value; });
    }
  }
  return occupied ? RayEnd::kOccupied : RayEnd::kVoid;
}

void OctreeView::ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const {
  const OccupancyOctree& tree = contents_->tree;
  const VoxelRange range = VoxelsOf(box_map, tree.resolution_m());
  const auto meets = [&](const NodeKey& first, int side) {
    return first.x <= range.last.x && first.y <= range.last.y && first.z <= range.last.z &&
           first.x + side > range.first.x && first.y + side > range.first.y && first.z + side > range.first.z;
  };
  const auto occupied = [this](const Field::Node& node) {
    return Field::NodeObserved(node) && ValueAt(node.max).state == CellState::kOccupied;
  };
  OccupancyOctree::FineLeaf leaf;
  for (const Chunk* chunk : tree.Chunks()) {
    const NodeKey corner{kChunkSide * chunk->key.x, kChunkSide * chunk->key.y, kChunkSide * chunk->key.z};
    if (!meets(corner, kChunkSide) || !occupied(chunk->level6)) continue;
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (!occupied(chunk->BlockNode(block))) continue;
      const NodeKey offset = BlockOffset(block);
      const NodeKey first{corner.x + kBlockSide * offset.x, corner.y + kBlockSide * offset.y,
                          corner.z + kBlockSide * offset.z};
      if (!meets(first, kBlockSide)) continue;
      tree.Expand(*chunk, block, &leaf);
      for (int i = 0; i < kBlockVoxels; ++i) {
        if (ValueAt(leaf.log_odds[i]).state != CellState::kOccupied) continue;
        const NodeKey voxel{first.x + (i & 7), first.y + (i >> 3 & 7), first.z + (i >> 6)};
        if (meets(voxel, 1)) visit(tree.CenterOf(voxel).cast<float>());
      }
    }
  }
}

}  // namespace atlas::mapping
