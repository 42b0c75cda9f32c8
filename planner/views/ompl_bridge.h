// The one door to OMPL: RRT and RRT* over the ground, whose floors may lie above one another.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/geometry.h"
#include "core/rng.h"
#include "planner/views/walkable.h"

namespace atlas::planner {

/// Frame: map. The callbacks are called from the calling thread only. States are (x, y); the height of each
/// is that of the ground to which the step from its parent leads, so that a state belongs to one floor.
/// Nearest neighbours are sought in the plane: where a tree has filled one floor, it hardly grows on another
/// above it, which the lattice reaches (LatticeCandidates).
struct GroundProblem {
  core::Vec3 start = core::Vec3::Zero();
  core::Vec2 min = core::Vec2::Zero(), max = core::Vec2::Zero();  ///< sampling bounds
  double step_m = 0.6;                                            ///< longest edge
  std::function<bool(const core::Vec2&)> can_stand;               ///< on one of the floors
  /// Where a free step from a place to (x, y) ends; nothing where it is not free.
  std::function<std::optional<core::Vec3>(const core::Vec3&, const core::Vec2&)> step;
  std::function<double(const core::Vec3&, const core::Vec3&)> effort;  ///< RRT* minimises its sum
};

/// Fills can_stand and step. `walkable` outlives the problem.
void FollowGroundOf(const Walkable& walkable, GroundProblem* problem);

/// Point 0 is the start; parents come before their children.
struct GroundTree {
  std::vector<core::Vec3> points;
  std::vector<int> parent;  ///< -1 for the start
  int attempts = 0;         ///< extensions tried
};

/// Grows an RRT without a goal until it has `nodes` nodes besides the start or `max_attempts` extensions were
/// tried (thesis 3.5, first phase). Samples prefer regions that the tree has not filled. Results depend on
/// the problem and `rng` only.
GroundTree GrowRrt(const GroundProblem& problem, int nodes, int max_attempts, core::Rng rng);

/// A way from the start to `goal` by RRT* with this many iterations (thesis 3.5, second phase), or nothing.
std::optional<std::vector<core::Vec3>> PlanRrtStar(const GroundProblem& problem, const core::Vec3& goal,
                                                   int iterations, core::Rng rng);

}  // namespace atlas::planner
