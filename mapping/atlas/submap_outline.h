// Which blocks of a submap hold anything: what boxes, indices and searches need of it.
#pragma once

#include <vector>

#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

struct SubmapOutline {
  struct Part {
    NodeKey chunk;
    BlockMask blocks;  ///< that hold a measured voxel, or one marked behind a surface
  };
  std::vector<Part> parts;  ///< by ascending Morton code
  double block_m = 0.0;     ///< side of a block
  core::Box3 bounds;        ///< of the blocks, in the submap's frame; empty where there is none

  /// Calls `visit(center_m)` on the centre of each block, in the submap's frame.
  template <typename Visit>
  void ForEachBlock(const Visit& visit) const {
    for (const Part& part : parts) {
      for (int block = 0; block < kChunkBlocks; ++block) {
        if (!part.blocks.Test(block)) continue;
        const NodeKey offset = BlockOffset(block);
        const core::Vec3 at(8 * part.chunk.x + offset.x, 8 * part.chunk.y + offset.y,
                            8 * part.chunk.z + offset.z);
        visit(core::Vec3(block_m * (at.array() + 0.5)));
      }
    }
  }
};

SubmapOutline OutlineOf(const OctreeContents& contents);

/// The box of an outline's blocks, aligned with another frame's axes (AABB, thesis 4.4.2).
core::Box3 BoxOf(const SubmapOutline& outline, const core::Pose& T_frame_submap);

/// The smallest axis-aligned box around a box that was moved by T. Empty stays empty.
core::Box3 BoxAround(const core::Box3& box, const core::Pose& T);

/// Half the size of the box around a cube of side `side_m` that T turned: sums of the rotation's absolute
/// rows.
inline core::Vec3 HalfSizeOfTurned(double side_m, const core::Pose& T) {
  return 0.5 * side_m * T.linear().cwiseAbs().rowwise().sum();
}

}  // namespace atlas::mapping
