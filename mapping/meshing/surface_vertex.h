// Where the surface crosses an edge between two voxel centres.
#pragma once

#include "mapping/meshing/block_samples.h"

namespace atlas::mapping {

/// In voxel centre coordinates of the block's samples (voxel i's centre is at i): the crossing of the edge
/// from voxel `low` along `axis`. Occupancy, where asked for, is moved inwards by OccupancyShift along the
/// smoothed gradient, at most to just before the middle of what is occupied there, so that thin sheets keep
/// their two sides apart.
/// @pre one end is inside, the other outside; both lie in [0, 9)^3.
template <typename Field>
core::Vec3f SurfaceVertex(const BlockSamples<Field>& samples, const NodeKey& low, int axis, bool undo_shift);

}  // namespace atlas::mapping
