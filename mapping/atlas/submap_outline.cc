#include "mapping/atlas/submap_outline.h"

namespace atlas::mapping {

using core::Box3;
using core::Vec3;

SubmapOutline OutlineOf(const OctreeContents& contents) {
  SubmapOutline outline;
  outline.block_m = kBlockSide * contents.tree.resolution_m();
  for (const OccupancyOctree::Chunk* chunk : contents.tree.Chunks()) {
    SubmapOutline::Part part{chunk->key, {}};
    for (int block = 0; block < kChunkBlocks; ++block) {
      const NodeKey offset = BlockOffset(block);
      const NodeKey first_voxel{8 * (8 * chunk->key.x + offset.x), 8 * (8 * chunk->key.y + offset.y),
                                8 * (8 * chunk->key.z + offset.z)};
      if (OccupancyField::NodeObserved(chunk->BlockNode(block)) ||
          (contents.behind && contents.behind->Find(first_voxel) != nullptr))
        part.blocks.Set(block);
    }
    if (part.blocks.Any()) outline.parts.push_back(part);
  }
  outline.ForEachBlock([&](const Vec3& center) {
    outline.bounds.Extend(center.array() - 0.5 * outline.block_m);
    outline.bounds.Extend(center.array() + 0.5 * outline.block_m);
  });
  return outline;
}

Box3 BoxOf(const SubmapOutline& outline, const core::Pose& T_frame_submap) {
  Box3 box;
  const Vec3 half = HalfSizeOfTurned(outline.block_m, T_frame_submap);
  outline.ForEachBlock([&](const Vec3& center_submap) {
    const Vec3 center = T_frame_submap * center_submap;
    box.Extend(center - half);
    box.Extend(center + half);
  });
  return box;
}

Box3 BoxAround(const Box3& box, const core::Pose& T) {
  Box3 around;
  if (box.Empty()) return around;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [&](int axis) { return (corner >> axis & 1) != 0 ? box.max[axis] : box.min[axis]; };
    around.Extend(T * Vec3(side(0), side(1), side(2)));
  }
  return around;
}

}  // namespace atlas::mapping
