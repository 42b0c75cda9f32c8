#include "planner/stopping/blocked_views.h"

#include <algorithm>

namespace atlas::planner {

void BlockedParams::Visit(core::ParamVisitor& v) {
  v.Field(
      "blocked_share", &blocked_share,
      {.min = 0.0,
       .max = 1.0,
       .doc = "views beyond a way too narrow keep the mission from being completed if worth this share of "
              "the best of all plans"});
}

BlockedViews::BlockedViews(const BlockedParams& params, const PlannerSetup& setup)
    : params_(params),
      footprint_{setup.robot.half_width_m, setup.robot.turning_radius_m, setup.terrain.edge_clearance_m} {}

void BlockedViews::Learn(const Belief& belief, const Ways& ways, DecisionLog* log) {
  ways_.Learn(ways.walkable, ways.tree, FindBlockedWays(ways.walkable, ways.tree, footprint_), belief.poses);
  log->blocked = ways_.ways();
}

bool BlockedViews::PromiseMore(const Belief& belief, const ViewPredictor& views, double greatest_value,
                               DecisionLog* log) {
  std::vector<double> shares;
  for (const double best : views.BestFrom(belief.map, ways_.PlacesBeyond(), log)) {
    // Where no plan ever saw anything worth while, whatever is beyond is.
    shares.push_back(greatest_value > 0.0 ? best / greatest_value : (best > 0.0 ? 1.0 : 0.0));
  }
  ways_.SetWorth(shares, params_.blocked_share);
  log->blocked = ways_.ways();
  return std::any_of(log->blocked->begin(), log->blocked->end(),
                     [](const BlockedWay& way) { return way.promises; });
}

}  // namespace atlas::planner
