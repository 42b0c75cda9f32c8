// Surfaces by Eq. 4.2, scattered hit by hit into the blocks that a scan's beams end in.
#pragma once

#include <array>
#include <vector>

#include "mapping/integrator/free_space/fill_kernels.h"
#include "mapping/integrator/measurement/surface_image.h"
#include "mapping/integrator/surface/hit_trails.h"
#include "mapping/integrator/surface/surface_model.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// Updates of the voxels near a scan's hits: 0 untouched, else the greatest over the hits.
struct HitBlock {
  alignas(64) int8_t delta[kBlockVoxels];
};

class HitScatter {
 public:
  /// Where the hits of the image lie against the lattice: fills `frame`, with a window that holds the end of
  /// every cell's ray; a spare hit outside is left out.
  static void Place(const RangeImage& image, const core::Pose& T_map_lidar, double resolution_m,
                    ScanFrame* frame);

  /// @param keep_min, keep_max  voxels outside [min, max) of the window are left out.
  void Scatter(const SurfaceImage& surface, const ScanFrame& frame, const SurfaceModel& model,
               const NodeKey& keep_min, const NodeKey& keep_max);

  /// Of the window.
  size_t chunks() const { return row_of_chunk_.size(); }
  /// Of a chunk of the window by its index x + chunks[0] * (y + chunks[1] * z); null where no hit touched it.
  const BlockMask* Touched(size_t chunk) const {
    const int32_t row = row_of_chunk_[chunk];
    return row == 0 ? nullptr : &touched_[static_cast<size_t>(row)];
  }
  const HitBlock& Block(size_t chunk, int block) const {
    const NodeKey b = BlockOffset(block);
    const auto at = static_cast<size_t>(row_of_chunk_[chunk] * kChunkBlocks + VoxelIndex(b.x, b.y, b.z));
    return blocks_[static_cast<size_t>(slots_[at])];
  }

 private:
  /// Of the hits in `which`, a bit a lane.
  template <typename Voxels>
  void ScatterVoxels(uint32_t which, Voxels* voxels);
  /// Makes room for what a group may touch, so that pointers into blocks_ stay good through it.
  void Reserve(TrailRules* rules);
  /// The slot of a block (HitTrails::block), made if it has none.
  size_t SlotOf(int32_t block);

  // Row 0 and slot 0 are none.
  std::vector<int32_t> row_of_chunk_;  ///< in touched_, and in slots_ times kChunkBlocks
  std::vector<BlockMask> touched_;
  std::vector<int32_t> slots_;  ///< of a chunk's blocks, x fastest
  std::vector<HitBlock> blocks_;
  size_t blocks_used_ = 0, rows_used_ = 0;
  size_t blocks_clear_ = 0;  ///< up to here blocks are all 0 when they are first used
  HitTrails trails_{};
  HitApproaches approaches_{};
  VoxelUpdates updates_;
};

}  // namespace atlas::mapping
