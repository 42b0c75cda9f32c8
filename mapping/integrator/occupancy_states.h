// From which log-odds on a voxel that the integrators fill is free, and from which occupied.
#pragma once

#include "mapping/integrator/integrator.h"
#include "mapping/octree/octree_view.h"

namespace atlas::mapping {

/// Free nodes keep the least that is known of their voxels, and cones claim free space only where no beam
/// contradicts, so one scan's miss decides free, and as much evidence as a scan gives of a surface decides
/// occupied (thesis 4.5.2: negative is free, positive occupied). Voxels between have seen both.
inline StateLogOdds StatesOf(const IntegratorParams& params) {
  // The planner calls a voxel occupied from 0.75 miss_nats on: the least that Eq. 4.2 gives behind a near
  // surface.
  constexpr double kSurfaceShare = 0.75;
  const double miss = OccupancyField::kNatsPerUnit * OccupancyField::StepsOf(params.miss_nats);
  return {-miss, kSurfaceShare * miss};
}

}  // namespace atlas::mapping
