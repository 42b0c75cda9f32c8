// What a session of SLAM remembers, for one that goes on from it.
#pragma once

#include <vector>

#include "mapping/slam/loop_search.h"
#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

struct SlamMemory {
  PoseGraph graph;                ///< without false loops
  std::vector<NodeMemory> nodes;  ///< one a node
};

}  // namespace atlas::mapping
