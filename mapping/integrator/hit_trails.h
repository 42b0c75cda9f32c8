// What hits say of the voxels around their ends (Eq. 4.2), 16 hits at a time.
#pragma once

#include <cstdint>

#include "mapping/integrator/fill_kernels.h"
#include "mapping/integrator/scan_image.h"
#include "mapping/integrator/surface_model.h"

namespace atlas::mapping {

constexpr size_t kHitGroup = 16;

/// Hits from the sensor, in voxels along the map's axes. A range of 0 or less: no hit.
struct HitGroup {
  alignas(64) float end[3][kHitGroup];
  alignas(64) float inward[3][kHitGroup];  ///< unit normal into the surface
  alignas(64) float support[kHitGroup];
  alignas(64) float range[kHitGroup];
};

/// The voxels that each hit of a group speaks of: the one that holds its end, then on along the beam, then
/// back. `delta` 0: nothing is said.
struct HitTrails {
  static constexpr int kBehind = 4, kInFront = 2, kVoxels = 1 + kBehind + kInFront;
  /// Chunk of the window times kChunkBlocks, and the block's place there, x fastest.
  alignas(64) int32_t block[kVoxels][kHitGroup];
  alignas(64) int32_t voxel[kVoxels][kHitGroup];  ///< VoxelIndex in the block
  /// Where it is held: the block's slot times kBlockVoxels, and its voxel. Slot 0, all 0, is for blocks that
  /// had none when asked.
  alignas(64) int32_t place[kVoxels][kHitGroup];
  alignas(64) int32_t delta[kVoxels][kHitGroup];
  uint32_t says[kVoxels];               ///< a bit a lane: delta is not 0
  uint32_t homeless[kVoxels];           ///< of those, the ones in slot 0
  alignas(64) int32_t said[kHitGroup];  ///< where the end's voxel holds this or more, the hit adds nothing
  uint32_t hits;  ///< a bit a lane; but for those after which the lane before has said it all
};

/// Where the cells' rays end, in voxels along the map's axes from the sensor, and what bounds that and the
/// sensor. @param rotation  row-major, voxels a metre.
void EndsOfCells(const ScanImage& image, const float rotation[9], float* const end[3], float low[3],
                 float high[3]);

/// The hits of a group that say more than is held already: of their ends' voxels, as they were before it.
/// @param held  of all slots, by HitTrails::place; aligned.
uint32_t NewHits(const HitTrails& trails, const int8_t* held);

/// What those hits say, one voxel after the other.
struct VoxelUpdates {
  static constexpr size_t kMost = HitTrails::kVoxels * kHitGroup;
  alignas(64) int32_t place[kMost + kHitGroup], delta[kMost + kHitGroup];  ///< as in HitTrails
  size_t count = 0;
};
void PackUpdates(const HitTrails& trails, uint32_t hits, VoxelUpdates* out);

struct TrailRules {
  SurfaceModel model;
  NodeKey keep_min, keep_max;  ///< voxels outside [min, max) of the window are left out
  float crowded_range_voxels;  ///< closer, hits are many a voxel, and the first that says most is enough
  /// Where blocks are held: of each chunk of the window its row in `slots`, of each block there its slot;
  /// row 0 and slot 0 are none.
  const int32_t *row_of_chunk, *slots;
};

/// Trails of the 16 cells of `image` from `first`. `end` are the ends of the cells' rays, as in HitGroup.
void TrailsOfCells(const ScanImage& image, const float* const end[3], size_t first, const ScanFrame& frame,
                   const TrailRules& rules, HitTrails* out);
void TrailsOfHits(const HitGroup& hits, const ScanFrame& frame, const TrailRules& rules, HitTrails* out);

}  // namespace atlas::mapping
