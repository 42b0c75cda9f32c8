// Doorways and other gaps that the robot passes straight on, though it cannot turn in them.
#pragma once

#include <vector>

#include "planner/views/walkable.h"

namespace atlas::planner {

/// A straight way between two places where the robot can stand at any heading. Between them it fits only
/// along the way.
struct Passage {
  core::Vec3 a = core::Vec3::Zero(), b = core::Vec3::Zero();
  double clearance_m = 0.0;  ///< it may be walked this much to the left or to the right of its line, at least
};

/// Of the level that the robot stands on: passages of at most `longest_m` between areas of the window that no
/// ground joins on which the robot can turn: of each gap one, in the middle of it and as square to it as it
/// has room. Each end has a run-up (up to 0.3 m) on ground where the robot can turn, so that it enters
/// aligned. The order depends on the map alone.
std::vector<Passage> FindPassages(const Walkable& walkable, double longest_m);

}  // namespace atlas::planner
