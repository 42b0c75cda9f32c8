// What planners and collision checks ask of an octree, at the coarsest level that answers.
//
// FirstOccupied and the state queries read the summaries of nodes: call Propagate first (integrators do).
#pragma once

#include <optional>
#include <span>

#include "mapping/map_view.h"
#include "mapping/octree/octree.h"
#include "mapping/octree/ray_walker.h"

namespace atlas::mapping {

/// Walks a ray to `max_range_m`, whole nodes at a time, nearest first, until `visit(const RaySegment&)`
/// returns false. Segments are contiguous from 0 to the range. @pre direction is unit.
template <typename Field, typename Visit>
void TraceRay(const Octree<Field>& map, const core::Vec3& origin, const core::Vec3& direction,
              double max_range_m, const Visit& visit) {
  RayWalker<Field> walker(map, origin, direction, max_range_m);
  while (!walker.done()) {
    RaySegment<Field> segment{Field::Unknown(), walker.t(), 0.0, kChunkLevel};
    if (const auto* chunk = walker.chunk()) {
      const NodeKey& voxel = walker.voxel();
      const int block = BlockIndexOf(voxel);
      const int index = VoxelIndex(voxel.x, voxel.y, voxel.z);
      switch (chunk->Kind(block)) {
        case BlockKind::kUniform:
          segment.value = chunk->uniform.Get(block);
          segment.level = UniformLevel<Field>(*chunk, block);
          break;
        case BlockKind::kCoarse:
          segment.value = map.Coarse(*chunk, block).Get(CellOfVoxel(index));
          segment.level = 1;
          break;
        case BlockKind::kFine:
          segment.value = map.Fine(*chunk, block).Get(index);
          segment.level = 0;
          break;
      }
    }
    segment.t_end_m = walker.Leave(segment.level);
    if (!visit(segment)) return;
  }
}

/// Distance to the first occupied cell, or nothing within the range; unknown space is passed.
template <typename Field>
std::optional<double> FirstOccupied(const Octree<Field>& map, const core::Vec3& origin,
                                    const core::Vec3& direction, double max_range_m);

/// Occupied if any voxel that meets the closed `box` is; else unknown if any is; else free.
template <typename Field>
CellState StateOfBox(const Octree<Field>& map, const core::Box3& box);

/// The same of a sphere moved along a polyline (a swept volume; one point is a sphere). Conservative by less
/// than half a voxel: counts voxels whose centre lies within the radius plus half a voxel's diagonal.
/// @pre path is not empty.
template <typename Field>
CellState StateOfSweptSphere(const Octree<Field>& map, std::span<const core::Vec3> path, double radius_m);

/// Calls `visit(const NodeKey& key, int level, Value value)` on every stored cell with a known value, by
/// Morton order of chunks and blocks, voxels x fastest; key counts cells of side 2^level (0, 1 or 3).
template <typename Field, typename Visit>
void ForEachCell(const Octree<Field>& map, const Visit& visit) {
  for (const auto* chunk : map.Chunks()) {
    for (int block = 0; block < kChunkBlocks; ++block) {
      const NodeKey offset = BlockOffset(block);
      const NodeKey at{8 * chunk->key.x + offset.x, 8 * chunk->key.y + offset.y, 8 * chunk->key.z + offset.z};
      const auto cells = [&](const auto& leaf, int level) {
        const int bits = kBlockLevel - level, mask = (1 << bits) - 1;
        for (int i = 0; i < 1 << 3 * bits; ++i) {
          const typename Field::Value value = leaf.Get(i);
          if (!Field::Known(value)) continue;
          visit(NodeKey{at.x << bits | (i & mask), at.y << bits | (i >> bits & mask),
                        at.z << bits | i >> 2 * bits},
                level, value);
        }
      };
      switch (chunk->Kind(block)) {
        case BlockKind::kUniform:
          if (Field::Known(chunk->uniform.Get(block))) visit(at, kBlockLevel, chunk->uniform.Get(block));
          break;
        case BlockKind::kCoarse:
          cells(map.Coarse(*chunk, block), 1);
          break;
        case BlockKind::kFine:
          cells(map.Fine(*chunk, block), 0);
          break;
      }
    }
  }
}

}  // namespace atlas::mapping
