// How far an estimated trajectory is from the true one.
#pragma once

#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

/// T_truth_map that lays the positions of `estimate` on those of `truth` with the least squared distance.
/// @pre as many poses in both, at least one.
core::Pose AlignTrajectory(const std::vector<core::Pose>& estimate, const std::vector<core::Pose>& truth);

/// Absolute trajectory error: root mean square distance of positions after that alignment.
double AbsoluteTrajectoryError(const std::vector<core::Pose>& estimate, const std::vector<core::Pose>& truth);

}  // namespace atlas::mapping
