// The pose graph of a robot that walks rooms in laps, with measured edges and the true poses beside them:
// what robust back ends are measured on.
#pragma once

#include <vector>

#include "core/rng.h"
#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

struct RoomGraph {
  PoseGraph graph;  ///< poses chained from measured odometry
  std::vector<core::Pose> T_true;
  /// The graph at its true poses.
  PoseGraph AtTruth() const {
    PoseGraph truth = graph;
    truth.T_map_node = T_true;
    return truth;
  }
};

/// Standard deviations an axis, of a 2 m step (RMS 1 m at 100 m) and of a loop.
struct EdgeNoise {
  double sigma_m = 0.02, sigma_rad = core::Radians(0.1);
};

/// xi of a measured T Exp(xi), translation before rotation.
core::Vec6 DrawError(const EdgeNoise& noise, bool planar, core::Rng* rng);

/// The true T_from_to, mismeasured.
PoseEdge MeasuredEdge(const RoomGraph& rooms, uint32_t from, uint32_t to, const EdgeNoise& noise,
                      core::Rng* rng);

/// Loops join nodes of different laps that are within 1.5 m, every `loop_every`th node to the first such.
RoomGraph MakeRoomGraph(uint32_t nodes, uint32_t loop_every, core::Rng rng, bool planar = false);

}  // namespace atlas::mapping
