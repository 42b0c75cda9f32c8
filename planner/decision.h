// What a plan decides, and all that decided it.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "core/geometry.h"

namespace atlas::planner {

enum class LossReason { kChosen, kLowerUtility, kBlacklisted, kUnreachable, kNoGain };

/// A viewpoint candidate x = (x, y, yaw) with all that decided about it; tables, plots and video recompute
/// nothing. What its planner does not compute is not set.
struct Candidate {
  core::Vec2 p_map = core::Vec2::Zero();
  double yaw_rad = 0.0;
  double ground_m = 0.0;       ///< height of the ground there
  int node = -1;               ///< RRT node it stands on
  double path_length_m = 0.0;  ///< along the tree
  std::optional<double> gain;  ///< g_x of the deciding gain
  double gain_void = 0.0, gain_ground = 0.0,
         gain_object = 0.0;  ///< of a gain that is set: split by where its rays end
  std::vector<double> extra_gains;
  std::optional<double> surface_m2;  ///< surface_frontier, where the planner decides by it
  std::optional<double> worth;       ///< what Eq. 3.1 takes for g_x: the gain, or the surface modulated by it
  std::optional<double> utility;     ///< Eq. 3.1
  double visited_cost = 0.0, too_close_cost = 0.0, position_cost = 0.0,
         traversal_cost = 0.0;  ///< of a utility that is set
  LossReason reason = LossReason::kLowerUtility;
};

/// Ground that a thinner robot would reach, and the narrowest place on the widest way to it.
struct BlockedWay {
  core::Vec2 p_map = core::Vec2::Zero();  ///< middle of the narrowest place
  double width_m = 0.0;                   ///< free width there
  /// What the robot needs: the width of its footprint, or, where that fits, of its turning circle.
  double needed_m = 0.0;
  std::vector<core::Vec3> beyond_map;  ///< ground points beyond it, spread out
  /// Of the best view from there over the best of all plans; nothing where no plan judged it.
  std::optional<double> worth_share = std::nullopt;
  bool promises = false;  ///< so much that it keeps the mission from being completed
};

/// A view to go to.
struct GoScan {
  core::Vec2 p_map = core::Vec2::Zero();
  double yaw_rad = 0.0;
  std::vector<core::Vec2> path_map;  ///< from the robot to the view
};

/// The mission ends by what the robot knows.
struct Done {
  enum class Reason {
    kGainExhausted,  ///< nothing reachable promises more (Eq. 3.8)
    kExplored,       ///< the same, of a whole space
    kSurfaceFlat,    ///< scans in a row brought next to no surface, whatever views promise
    kRouteDone,      ///< all views of a given route were visited
    kBlockedNarrow   ///< as one of the others, but views that promise more lie beyond ways too narrow
  };
  Reason reason = Reason::kGainExhausted;
};

/// The mission ends because nothing can be done.
struct Stuck {
  enum class Reason {
    kOutOfReach,   ///< nothing of the object was seen from within range, and no way brings the robot nearer
    kNoCandidates  ///< no place to go to
  };
  Reason reason = Reason::kNoCandidates;
};

using Decision = std::variant<GoScan, Done, Stuck>;

/// All that a plan considered; tables, plots and video recompute nothing. What its planner does not compute
/// is not set.
struct DecisionLog {
  std::vector<Candidate> candidates;
  int best = -1;  ///< index into candidates
  std::optional<size_t> views_predicted;
  int nodes_obtained = 0;
  int attempts = 0;
  size_t rays_traced = 0;
  std::optional<double> utility_ratio;  ///< best over the greatest so far
  double path_length_m = 0.0;           ///< of the way to the best view
  /// Ways thought too narrow, all that are known; judged (worth_share) by the plan that ends the mission.
  std::optional<std::vector<BlockedWay>> blocked;
};

}  // namespace atlas::planner
