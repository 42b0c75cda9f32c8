// Views beyond ways too narrow for the robot: whether a mission that would be done left something behind.
#pragma once

#include "core/params.h"
#include "planner/belief.h"
#include "planner/decision.h"
#include "planner/graph/blocked_ways.h"
#include "planner/views/planner_setup.h"
#include "planner/views/view_predictor.h"

namespace atlas::planner {

struct BlockedParams {
  /// At the end: views beyond a way too narrow for the robot promise more if worth this share of the best of
  /// all plans.
  double blocked_share = 0.2;
  void Visit(core::ParamVisitor& v);
};

class BlockedViews {
 public:
  BlockedViews(const BlockedParams& params, const PlannerSetup& setup);

  /// Finds the blocked ways about the robot, and lists all that are known in the log.
  void Learn(const Belief& belief, const Ways& ways, DecisionLog* log);
  /// Whether a view beyond one of them, predicted as if the robot stood there, promises what would be worth
  /// going for. `greatest_value`: of any view of any plan so far (ViewPredictor::ValueOf).
  bool PromiseMore(const Belief& belief, const ViewPredictor& views, double greatest_value, DecisionLog* log);

 private:
  BlockedParams params_;
  Footprint footprint_;
  BlockedWays ways_;
};

}  // namespace atlas::planner
