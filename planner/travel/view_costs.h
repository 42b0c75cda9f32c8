// What every candidate of a plan costs, and its utility (thesis 3.4.2, Eq. 3.1 and 3.7).
#pragma once

#include <string>
#include <vector>

#include "core/params.h"
#include "planner/belief.h"
#include "planner/decision.h"
#include "planner/travel/costs.h"
#include "planner/views/candidates.h"
#include "planner/views/planner_setup.h"

namespace atlas::planner {

/// Position cost (Eq. 3.7) as two terms; the maximum of both equals the thesis's at equal thresholds.
struct CostParams {
  bool visited_cost = true;
  double visited_threshold_m = 2.0;
  bool too_close_cost = true;
  double too_close_threshold_m = 1.5;
  double behind_penalty = 0.2;           ///< constant traversal cost for candidates behind the robot
  std::string traversal = "continuous";  ///< discrete (thesis) | continuous (time, slope, roughness, turning)
  double time_scale_s = 60.0;            ///< continuous: travel of this long costs 1 - 1/e
  void Visit(core::ParamVisitor& v);
};

class ViewCosts {
 public:
  /// `sensor_height_m` above the ground: of where views are seen from.
  ViewCosts(const CostParams& params, const PlannerSetup& setup, double sensor_height_m);

  /// Fills costs and utility of the log's candidates, whose worth is set. `scanned` are the places of all
  /// scans so far.
  void Charge(const Belief& belief, const Ways& ways, const std::vector<core::Vec2>& scanned,
              DecisionLog* log) const;

 private:
  CostParams params_;
  TraversalModel traversal_;
  core::Box3 kept_map_;
  double sensor_height_m_;
};

}  // namespace atlas::planner
