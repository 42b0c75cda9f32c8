// OctoMap as a mapper backend.
#pragma once

#include <memory>

#include "mapping/mapper.h"

namespace atlas::mapping {

/// The OctoMap library at one resolution over the object's region. A spin updates each voxel once, hits
/// before misses (OctoMap's computeUpdate rule); log-odds accumulate in a dense mirror of the region and
/// reach the octree when it is read, which gives the same tree as one library call a spin, many times faster.
std::unique_ptr<Mapper> BuildOctomapMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>& lidar);

}  // namespace atlas::mapping
