// The planner seam: what is known in, a decision out.
#pragma once

#include "planner/belief.h"
#include "planner/decision.h"

namespace atlas::planner {

/// What a scan brought.
struct ScanOutcome {
  core::Pose T_map_base = core::Pose::Identity();  ///< where it was taken
  size_t new_surface =
      0;  ///< voxels that returned for the first time (SurfaceTally): whether the view kept its promise
};

class Planner {
 public:
  virtual ~Planner() = default;
  /// Told after every scan, before the plan that follows it.
  virtual void OnScan(const ScanOutcome& scan, const core::PoseSource& poses) = 0;
  /// `log` is fresh, and receives all that decided.
  virtual Decision Plan(const Belief& belief, DecisionLog* log) = 0;
};

}  // namespace atlas::planner
