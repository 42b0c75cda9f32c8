// The way to a view: RRT* over the traversable ground, then short cuts (thesis 3.5, second phase).
#pragma once

#include <vector>

#include "core/rng.h"
#include "planner/views/walkable.h"

namespace atlas::planner {

/// Horizontal length of a polyline, metres.
double PathLength(const std::vector<core::Vec2>& path);
double PathLength(const std::vector<core::Vec3>& path);

/// Replans `tree_path` (from the robot to the view, feasible) by RRT* around it and straightens the result;
/// the straightened tree path where RRT* finds nothing better. Starts and ends where `tree_path` does.
/// @pre tree_path has at least one point.
std::vector<core::Vec3> PlanViewPath(const Walkable& walkable, const std::vector<core::Vec3>& tree_path,
                                     int iterations, const core::Rng& rng);

/// The same between passages: steps `tree_path[i]` to `tree_path[i + 1]`, i in `narrow` (ascending), are
/// walked as they are.
std::vector<core::Vec3> PlanViewPath(const Walkable& walkable, const std::vector<core::Vec3>& tree_path,
                                     const std::vector<size_t>& narrow, int iterations, const core::Rng& rng);

/// Drops every waypoint that a free straight step can skip without more effort. Waypoints that stay are ones
/// of `path`, where the robot can turn.
std::vector<core::Vec3> Shortcut(const Walkable& walkable, const std::vector<core::Vec3>& path);

}  // namespace atlas::planner
