// A planner that plans nothing: it visits the views it is given, in their order. For experiments in which all
// runs are to see from the same places.
#pragma once

#include <memory>

#include "planner/planners/nbv_planner.h"

namespace atlas::planner {

/// `stops` are texts "X Y" (m, map frame: passed by) and "X Y YAW" (deg: a view), the first where the robot
/// starts. Ways between stops are straight, and begin at the stop before, wherever the robot believes to be.
/// After the last view the route is done, and the mission with it.
/// @throws InputError "planner.route: ..." for fewer than two stops, a text of another form, or no view.
std::unique_ptr<NbvPlanner> MakeRoutePlanner(const std::vector<std::string>& stops);

}  // namespace atlas::planner
