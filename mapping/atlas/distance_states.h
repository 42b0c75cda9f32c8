// Signed distances as states: what planning and clustering ask of a submap that holds distances.
#pragma once

#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// Writes to `tree` which voxels of these blocks of a chunk are free (distance above zero) and which
/// occupied, each as sure as log-odds can be; unknown where the weight is zero. Blocks stay as coarse as
/// distances have them, those of one state throughout become uniform. Summaries of `tree` are current
/// afterwards.
/// @pre both of one resolution
void TellStates(const TsdfOctree& distances, const NodeKey& chunk, const BlockMask& blocks,
                OccupancyOctree* tree);
/// Of all chunks, to an empty tree.
OccupancyOctree StatesOf(const TsdfOctree& distances);

}  // namespace atlas::mapping
