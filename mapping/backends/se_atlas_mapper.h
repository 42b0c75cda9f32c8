// SE-Atlas as a mapper backend: `mapper.name: se_atlas`.
#pragma once

#include <memory>

#include "mapping/mapper.h"

namespace atlas::mapping {

/// A multi-resolution occupancy octree, fed spin by spin with per-ray poses through the cones of the beam
/// table that `lidar` tells, ray by ray where it is absent. Planners read a dense mirror of the region, which
/// takes over the octree's changed blocks when it is asked for.
std::unique_ptr<Mapper> BuildSeAtlasMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>& lidar);

}  // namespace atlas::mapping
