#include "planner/planners/nbv_parts.h"

#include <algorithm>
#include <variant>

#include "planner/stopping/unpromising_views.h"

namespace atlas::planner {

void NbvParams::Visit(core::ParamVisitor& v) {
  views.Visit(v);
  costs.Visit(v);
  blocked.Visit(v);
  travel.Visit(v);
}

NbvParts::NbvParts(const NbvParams& params, const GainRoles& gains, const PlannerSetup& setup)
    : goal(setup.goal),
      robot(setup.robot),
      window_m(params.views.window_m),
      views(params.views, gains, setup),
      costs(params.costs, setup, views.sensor_height_m()),
      blocked(params.blocked, setup),
      travel(params.travel) {}

Walkable NbvParts::Begin(const Belief& belief) {
  memory.Correct(belief.poses);
  return {belief.ground, belief.p_map(), window_m};
}

void NbvParts::Places(const Belief& belief, const Ways& ways, DecisionLog* log) {
  log->nodes_obtained = static_cast<int>(ways.tree.nodes.size());
  log->views_predicted = 0;
  log->attempts = ways.tree.attempts;
  blocked.Learn(belief, ways, log);
}

Decision NbvParts::WithoutPlaces(const Belief& belief, DecisionLog* log) {
  if (auto move = travel.Recover(belief, robot.GroundUnder(belief.T_map_base), log)) return *move;
  if (blocked.PromiseMore(belief, views, greatest_value, log)) return Done{Done::Reason::kBlockedNarrow};
  return Stuck{Stuck::Reason::kNoCandidates};
}

void NbvParts::PredictViews(const Belief& belief, const Ways& ways, DecisionLog* log) {
  views.Predict(belief.map, ways, log);
  log->views_predicted = log->candidates.size();
  for (const Candidate& c : log->candidates) greatest_value = std::max(greatest_value, views.ValueOf(c));
}

int NbvParts::NearerToObject(const DecisionLog& log) const {
  return NearestToObject(log.candidates, memory.visited(), views.goal_box(), views.max_range_m());
}

Decision NbvParts::End(Done::Reason reason, const Belief& belief, DecisionLog* log) {
  if (blocked.PromiseMore(belief, views, greatest_value, log)) return Done{Done::Reason::kBlockedNarrow};
  const bool seen = memory.surface_seen() > 0.0 &&
                    DistanceToObject(memory.visited(), views.goal_box()) <= views.max_range_m();
  if (!seen) return Stuck{Stuck::Reason::kOutOfReach};
  const bool is_space = std::holds_alternative<WholeSpace>(goal);
  if (is_space && reason == Done::Reason::kGainExhausted) return Done{Done::Reason::kExplored};
  return Done{reason};
}

void WorthIsGain(DecisionLog* log) {
  for (Candidate& c : log->candidates) c.worth = c.gain;
}

Decision NbvParts::GoTo(int view, const Belief& belief, const Ways& ways, const core::Rng& rng,
                        DecisionLog* log) {
  const GoScan go = travel.GoTo(view, belief, ways, rng, log);
  memory.Commit({go.p_map, go.yaw_rad}, belief.poses);
  return go;
}

}  // namespace atlas::planner
