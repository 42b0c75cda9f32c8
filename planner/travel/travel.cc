#include "planner/travel/travel.h"

#include "planner/travel/view_path.h"

namespace atlas::planner {

void TravelParams::Visit(core::ParamVisitor& v) {
  v.Field("rrt_star_iterations", &rrt_star_iterations,
          {.min = 0, .max = 100000, .doc = "iterations of RRT* on the way to the view"});
}

GoScan Travel::GoTo(int view, const Belief& belief, const Ways& ways, const core::Rng& rng,
                    DecisionLog* log) {
  Candidate& c = log->candidates[static_cast<size_t>(view)];
  c.reason = LossReason::kChosen;
  GoScan go{.p_map = c.p_map, .yaw_rad = c.yaw_rad, .path_map = {}};
  const std::vector<core::Vec3> way =
      PlanViewPath(ways.walkable, ways.tree.PathTo(c.node, ways.walkable.start()),
                   ways.tree.NarrowSteps(c.node), params_.rrt_star_iterations, rng.Split("path"));
  for (const core::Vec3& p : way) go.path_map.push_back(p.head<2>());
  log->best = view;
  log->path_length_m = PathLength(go.path_map);
  recovery_.SetOut(way, belief.poses);
  return go;
}

std::optional<GoScan> Travel::Recover(const Belief& belief, double ground_m, DecisionLog* log) {
  const auto move = recovery_.Next(belief.T_map_base, belief.ground, belief.poses);
  if (!move) return std::nullopt;
  log->path_length_m = PathLength(move->path_map);
  Candidate there;
  there.p_map = move->path_map.back();
  there.ground_m = ground_m;
  there.yaw_rad = move->yaw_rad;
  there.path_length_m = log->path_length_m;
  there.reason = LossReason::kChosen;
  log->candidates = {there};
  log->best = 0;
  return GoScan{.p_map = there.p_map, .yaw_rad = there.yaw_rad, .path_map = move->path_map};
}

}  // namespace atlas::planner
