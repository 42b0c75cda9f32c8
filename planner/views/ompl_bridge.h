// The one door to OMPL: RRT and RRT* in the plane.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "core/rng.h"

namespace atlas::planner {

/// Frame: map. The callbacks are called from the calling thread only.
struct PlanarProblem {
  core::Vec2 start = core::Vec2::Zero();
  core::Vec2 min = core::Vec2::Zero(), max = core::Vec2::Zero();  ///< sampling bounds
  double step_m = 0.6;                                            ///< longest edge
  std::function<bool(const core::Vec2&)> can_stand;
  std::function<bool(const core::Vec2&, const core::Vec2&)> can_step;
  std::function<double(const core::Vec2&, const core::Vec2&)> effort;  ///< RRT* minimises its sum
};

/// Point 0 is the start; parents come before their children.
struct PlanarTree {
  std::vector<core::Vec2> points;
  std::vector<int> parent;  ///< -1 for the start
  int attempts = 0;         ///< extensions tried
};

/// Grows an RRT without a goal until it has `nodes` nodes besides the start or `max_attempts` extensions were
/// tried (thesis 3.5, first phase). Samples prefer regions that the tree has not filled. Results depend on
/// the problem and `rng` only.
PlanarTree GrowRrt(const PlanarProblem& problem, int nodes, int max_attempts, core::Rng rng);

/// A way from the start to `goal` by RRT* with this many iterations (thesis 3.5, second phase), or nothing.
std::optional<std::vector<core::Vec2>> PlanRrtStar(const PlanarProblem& problem, const core::Vec2& goal,
                                                   int iterations, core::Rng rng);

}  // namespace atlas::planner
