// The OctoMap library as a mapper backend: `mapper.name: octomap`.
#pragma once

#include <memory>

#include "mapping/backends/catalog.h"

namespace atlas::mapping {

/// OctoMap's own tree, of the setup's box where it has one, updated as the revolutions come, a revolution an
/// update of OctoMap's discretised kind: one ray per end voxel, to that voxel's centre, each from its own
/// sensor position; every voxel changes once, hits before misses. Rays that pass through the box are cut
/// where they leave it. Views read the tree.
std::unique_ptr<Map> BuildOctomapMap(const MapperParams& params, const MapSetup& setup);

}  // namespace atlas::mapping
