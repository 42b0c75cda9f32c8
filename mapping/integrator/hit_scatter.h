// Surfaces by Eq. 4.2, scattered hit by hit into the blocks that a scan's beams end in.
#pragma once

#include <array>
#include <vector>

#include "mapping/integrator/fill_kernels.h"
#include "mapping/integrator/hit_trails.h"
#include "mapping/integrator/scan_image.h"
#include "mapping/integrator/surface_model.h"
#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// Updates of the voxels near a scan's hits: 0 untouched, else the greatest over the hits.
struct HitBlock {
  alignas(64) int8_t delta[kBlockVoxels];
};

class HitScatter {
 public:
  /// Where the hits of the image lie against the lattice: fills `frame`'s window so that it holds every ray's
  /// end, and keeps window coordinates for Scatter.
  void Place(const ScanImage& image, const core::Pose& T_map_lidar, double resolution_m, ScanFrame* frame);

  /// @param keep_min, keep_max  voxels outside [min, max) of the window are left out.
  void Scatter(const ScanImage& image, const ScanFrame& frame, const SurfaceModel& model,
               const NodeKey& keep_min, const NodeKey& keep_max);

  /// Of a chunk of the window by its index x + chunks[0] * (y + chunks[1] * z); null where no hit touched it.
  const BlockMask* Touched(size_t chunk) const {
    return slot_of_chunk_[chunk] == 0 ? nullptr : &chunks_[slot_of_chunk_[chunk]].touched;
  }
  const HitBlock& Block(size_t chunk, int block) const {
    return blocks_[chunks_[slot_of_chunk_[chunk]].slot[static_cast<size_t>(block)]];
  }

 private:
  struct ChunkHits {
    BlockMask touched;
    std::array<uint32_t, kChunkBlocks> slot;
  };
  void ScatterTrails(const HitTrails& trails);
  void FillSpare(const ScanImage& image, const ScanFrame& frame, const ScanImage::SpareHit& spare,
                 size_t lane, HitGroup* group) const;
  int8_t* BlockAt(int32_t block);

  std::vector<float> wx_, wy_, wz_;  ///< ends of the hits from the sensor, voxels along the map's axes
  std::vector<uint32_t> slot_of_chunk_;
  std::vector<ChunkHits> chunks_;
  std::vector<HitBlock> blocks_;
  size_t blocks_used_ = 0, chunks_used_ = 0;
};

}  // namespace atlas::mapping
