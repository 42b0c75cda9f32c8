// Poses to start an optimiser from, by two sparse linear least-squares problems (Carlone et al.,
// "Initialization techniques for 3D SLAM", ICRA 2015).
#pragma once

#include <vector>

#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

/// The minimiser of the chordal cost in two steps: rotations as free 3 x 3 matrices, projected to SO(3); then
/// translations. Fixed nodes keep the poses that the graph has. Where the equations cannot be solved, the
/// graph's own poses are returned.
/// @pre the graph is connected (ComponentsOf).
std::vector<core::Pose> ChordalStart(const PoseGraph& graph);

}  // namespace atlas::mapping
