// From the place that a plan chose to the way there, or to what is tried where there is no place to choose.
#pragma once

#include <optional>

#include "core/params.h"
#include "planner/belief.h"
#include "planner/decision.h"
#include "planner/travel/recovery.h"
#include "planner/views/candidates.h"

namespace atlas::planner {

struct TravelParams {
  int rrt_star_iterations = 800;
  void Visit(core::ParamVisitor& v);
};

class Travel {
 public:
  explicit Travel(const TravelParams& params) : params_(params) {}

  /// Sends the robot to the log's candidate `view`, whose node is one of the tree, by RRT*.
  GoScan GoTo(int view, const Belief& belief, const Ways& ways, const core::Rng& rng, DecisionLog* log);
  /// Where no place can be reached: the next thing to try (see Recovery), as the log's only candidate; or
  /// nothing.
  std::optional<GoScan> Recover(const Belief& belief, double ground_m, DecisionLog* log);

 private:
  TravelParams params_;
  Recovery recovery_;
};

}  // namespace atlas::planner
