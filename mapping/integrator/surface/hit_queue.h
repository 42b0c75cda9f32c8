// The hits of a scan on their way into the map, less those that would repeat the update of others.
#pragma once

#include <cstdint>

#include "mapping/integrator/free_space/fill_kernels.h"
#include "mapping/integrator/measurement/surface_image.h"
#include "mapping/integrator/surface/surface_model.h"

namespace atlas::mapping {

constexpr size_t kHitGroup = 16;

/// Hits that wait until there is a group of them: from the sensor, in voxels along the map's axes. A range of
/// 0 or less: no hit.
struct HitQueue {
  static constexpr size_t kRoom = 2 * kHitGroup;
  alignas(64) float end[3][kRoom];
  alignas(64) float inward[3][kRoom];  ///< unit normal into the surface
  alignas(64) float range[kRoom];
  size_t count = 0;
};

struct TrailRules {
  SurfaceModel model;
  NodeKey keep_min, keep_max;  ///< voxels outside [min, max) of the window are left out
  float dense_range_voxels;    ///< farther, hardly a voxel holds two hits
  /// Where blocks are held: of each chunk of the window its row in `slots`, of each block there its slot;
  /// row 0 and slot 0 are none.
  const int32_t *row_of_chunk, *slots;
};

/// Bounds of the sensor and of where the cells' rays end, in voxels along the map's axes from the sensor.
/// @param frame  its axes and resolution.
void BoundsOfEnds(const RangeImage& image, const ScanFrame& frame, float low[3], float high[3]);

/// Queues the hits of the 16 cells of the image from `first` that would change the voxels that they end
/// in. `held` as for NewHits (hit_trails.h).
void QueueCells(const SurfaceImage& surface, size_t first, const ScanFrame& frame, const TrailRules& rules,
                const int8_t* held, HitQueue* queue);

}  // namespace atlas::mapping
