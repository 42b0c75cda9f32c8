// Adds a scan's distances to stored running means, many voxels at a time.
#pragma once

#include <cstdint>

#include "mapping/octree/fields.h"

namespace atlas::mapping {

constexpr int16_t kNoDistance = INT16_MIN;  ///< no measurement of a voxel

/// Running means of `layers` times 64 voxels. Where measured (may be null) is not kNoDistance, takes it in;
/// else where a bit of free (may be null for all) is set, takes in `free_distance`. Returns whether any
/// changed.
bool ApplyDistances(int16_t* distance, uint8_t* weight, int layers, const uint64_t* free,
                    const int16_t* measured, int16_t free_distance);

}  // namespace atlas::mapping
