// The planner seam: what is known in, a decision out.
#pragma once

#include "mapping/map_view.h"
#include "mapping/terrain/traversable_ground.h"
#include "planner/decision.h"

namespace atlas::planner {

class NbvPlanner {
 public:
  virtual ~NbvPlanner() = default;
  /// Tells the planner that a sweep was taken at this base pose, and the share of ground-truth-free progress:
  /// `new_surface` = voxels of the object that returned for the first time (SurfaceTally), so that views that
  /// promise and do not deliver are blacklisted.
  virtual void OnSweep(const core::Pose& T_map_base, size_t new_surface) = 0;
  virtual NbvDecision Plan(const core::Pose& T_map_base, const mapping::MapView& map,
                           const mapping::TraversableGround& terrain) = 0;
};

}  // namespace atlas::planner
