// What hits say of the voxels around their ends (Eq. 4.2), 16 hits at a time.
#pragma once

#include <cstdint>

#include "mapping/integrator/hit_queue.h"

namespace atlas::mapping {

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
  uint32_t hits;                        ///< a bit a lane
};

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

/// Takes the first group out of the queue and follows it. @pre queue->count > 0.
void TakeTrails(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitTrails* out);

}  // namespace atlas::mapping
