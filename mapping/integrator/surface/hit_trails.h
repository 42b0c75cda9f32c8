// Log-odds updates around the ends of hits by the inverse sensor model of Eq. 4.2, 16 hits at a time.
//
//      L(d)  free, -miss_nats          hit_nats (the voxel of the return)
//                                       .
//      ---------------------+          /|\   near_nats
//                            \        / | '--------.
//      0 ---------------------\------+--+----------+-------- distance along the beam
//                              \    /               behind lambda_r d: no update
//                          -3 sigma  surface
#pragma once

#include <cstdint>

#include "mapping/integrator/surface/hit_queue.h"

namespace atlas::mapping {

/// Voxels that the hits of a group update, kMost a hit.
template <int kMost>
struct TrailVoxels {
  static constexpr int kVoxels = kMost;
  /// Chunk of the window times kChunkBlocks, and the block's place there, x fastest.
  alignas(64) int32_t block[kVoxels][kHitGroup];
  alignas(64) int32_t voxel[kVoxels][kHitGroup];  ///< VoxelIndex in the block
  /// Where it is held: the block's slot times kBlockVoxels, and its voxel. Slot 0, all 0, is for blocks that
  /// had none when asked.
  alignas(64) int32_t place[kVoxels][kHitGroup];
  alignas(64) int32_t delta[kVoxels][kHitGroup];
  uint32_t updates[kVoxels];      ///< a bit a lane: delta is not 0
  uint32_t unallocated[kVoxels];  ///< of those, the ones in slot 0
};

constexpr int kTrailBehind = 4, kTrailInFront = 2;

/// Updates of the voxel that holds each hit's end, then on along the beam, then back.
struct HitTrails : TrailVoxels<1 + kTrailBehind + kTrailInFront> {
  alignas(64) int32_t
      saturated_at[kHitGroup];  ///< where the end's voxel holds this or more, the hit adds nothing
  uint32_t hits;                ///< a bit a lane
  uint32_t oblique;             ///< of those, the ones whose approach is worth following
};

/// Updates of the voxels farther back along the beam, while the hit's plane is near: those that it cuts
/// hold surface, those in front of it are free, whatever returned from around them.
using HitApproaches = TrailVoxels<32>;

/// Bitmask of hits whose end voxel would change, judged by its value before this group.
/// @param held  of all slots, by HitTrails::place; aligned.
uint32_t NewHits(const HitTrails& trails, const int8_t* held);

/// The updates of those hits, one voxel after the other.
struct VoxelUpdates {
  static constexpr size_t kMost = HitApproaches::kVoxels * kHitGroup;
  alignas(64) int32_t place[kMost + kHitGroup], delta[kMost + kHitGroup];  ///< as in HitTrails
  size_t count = 0;
};
/// @param hits  a bit a lane.
/// @{
void PackUpdates(const HitTrails& trails, uint32_t hits, VoxelUpdates* out);
void PackUpdates(const HitApproaches& approaches, uint32_t hits, VoxelUpdates* out);
/// @}

/// Follow the first group of the queue. @pre queue->count > 0.
/// @{
void FollowTrails(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitTrails* out);
void FollowApproaches(const ScanFrame& frame, const TrailRules& rules, HitQueue* queue, HitApproaches* out);
/// @}
/// Takes the first group out of the queue; those in `which`, a bit a lane, join the other queue.
/// @pre others->count < kHitGroup.
void TakeGroup(uint32_t which, HitQueue* queue, HitQueue* others);

}  // namespace atlas::mapping
