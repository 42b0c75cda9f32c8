// The parts that planners of next best views are composed of, and what they all do alike.
#pragma once

#include "planner/planners/planner_params.h"
#include "planner/stopping/blocked_views.h"
#include "planner/stopping/view_memory.h"
#include "planner/travel/travel.h"
#include "planner/travel/view_costs.h"
#include "planner/views/view_predictor.h"

namespace atlas::planner {

struct NbvParams {
  ViewParams views;
  CostParams costs;
  BlockedParams blocked;
  TravelParams travel;
  void Visit(core::ParamVisitor& v);
};

/// A view is worth its gain (Eq. 3.1).
void WorthIsGain(DecisionLog* log);

struct NbvParts {
  /// @throws InputError for an unknown gain.
  NbvParts(const NbvParams& params, const GainRoles& gains, const PlannerSetup& setup);

  /// Begins a plan: everything remembered moves to where it lies now.
  Walkable Begin(const Belief& belief);
  /// Notes the places that a plan may choose from, and what lies behind ways too narrow.
  void Places(const Belief& belief, const Ways& ways, DecisionLog* log);
  /// Where there is no place to choose from: back, a turn, a step aside; in the end the mission ends.
  Decision WithoutPlaces(const Belief& belief, DecisionLog* log);
  /// Predicts the views of a plan's places.
  void PredictViews(const Belief& belief, const Ways& ways, DecisionLog* log);
  /// Predicts them and what they cost; `value` sets what Eq. 3.1 takes for g_x.
  template <typename Value>
  void ValueViews(const Belief& belief, const Ways& ways, const Value& value, DecisionLog* log) {
    PredictViews(belief, ways, log);
    value(log);
    costs.Charge(belief, ways, memory.visited(), log);
  }
  /// Of an object that is too far away for any plan so far to predict views of it, a view nearer to it; else
  /// -1.
  int NearerToObject(const DecisionLog& log) const;
  /// Ends the mission: by this reason, unless what was seen, or lies behind a way too narrow, speaks against
  /// it.
  Decision End(Done::Reason reason, const Belief& belief, DecisionLog* log);
  /// Sends the robot to the log's candidate.
  Decision GoTo(int view, const Belief& belief, const Ways& ways, const core::Rng& rng, DecisionLog* log);

  Goal goal;
  RobotModel robot;
  double window_m;
  ViewPredictor views;
  ViewCosts costs;
  ViewMemory memory;
  BlockedViews blocked;
  Travel travel;
  double greatest_value = 0.0;  ///< of a view, before anything modulates it; over all plans
};

}  // namespace atlas::planner
