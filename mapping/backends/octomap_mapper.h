// The OctoMap library as a mapper backend: `mapper.name: octomap`.
#pragma once

#include <memory>

#include "mapping/mapper.h"

namespace atlas::mapping {

/// OctoMap's own tree over the object's region, updated as the revolutions come, a revolution an update of
/// OctoMap's discretised kind: one ray per end voxel, to that voxel's centre, each from its own sensor
/// position; every voxel changes once, hits before misses. Rays that pass through the region are cut where
/// they leave it. The view reads the tree.
std::unique_ptr<Mapper> BuildOctomapMapper(const MapperParams& params, const core::Box3& object_box,
                                           const std::optional<core::LidarModel>& lidar);

}  // namespace atlas::mapping
