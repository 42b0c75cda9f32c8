// SE-Atlas as a map: `mapper.name: se_atlas`.
#pragma once

#include <memory>

#include "mapping/backends/catalog.h"

namespace atlas::mapping {

/// A multi-resolution occupancy octree, fed revolution by revolution with per-ray poses through the cones of
/// the beam table that the setup's LiDAR tells, ray by ray where it is absent.
std::unique_ptr<Map> BuildSeAtlasMap(const MapperParams& params, const MapSetup& setup);

}  // namespace atlas::mapping
