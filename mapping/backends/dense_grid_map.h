// A dense occupancy grid of our own: `mapper.name: dense_grid`.
#pragma once

#include <memory>

#include "mapping/backends/catalog.h"

namespace atlas::mapping {

/// OctoMap's update rule (each voxel once a revolution, hits before misses) on an array over the object's
/// region: many times faster than a tree, at the price of the whole region's memory. Of the rays that end in
/// one voxel the first is traced.
/// @throws InputError without a box to keep.
std::unique_ptr<Map> BuildDenseGridMap(const MapperParams& params, const MapSetup& setup);

}  // namespace atlas::mapping
