// The back end of SLAM (thesis Fig. 4.6): takes finished nodes, finds their loops and says where all nodes
// lie.
//
// It is the same whatever thread runs it, as long as calls come one after another in the same order.
#pragma once

#include <memory>
#include <vector>

#include "mapping/slam/loop_search.h"
#include "mapping/slam/pose_graph_slam.h"

namespace atlas::mapping {

/// A node that is left behind, and the edge that leads to it.
struct FinishedNode {
  core::Pose T_previous_node = core::Pose::Identity();  ///< by odometry; the first node has none before it
  core::Mat6 information = core::Mat6::Identity();
  NodeCloud cloud;
};

/// Where the nodes lie that the back end has taken so far.
struct SolvedNodes {
  std::vector<core::Pose> T_map_node;
  uint64_t version = 0;
  bool full_pass_due = false;                     ///< a tenth of all loops have come since the last one
  std::shared_ptr<const PoseGraph> inliers = {};  ///< that the poses come from, as of `version`
};

class SlamBackEnd {
 public:
  SlamBackEnd(const SlamParams& params, const core::Pose& T_map_first);

  /// Searches loops from the node; where one is found, all are solved for anew, fast.
  SolvedNodes Take(const FinishedNode& node);
  /// The full robust pass.
  SolvedNodes FullPass();

  const PoseGraphSlam& graph() const { return graph_; }

 private:
  SolvedNodes Solved();

  SlamParams params_;
  PoseGraphSlam graph_;
  LoopSearch search_;
  bool first_ = true;
  size_t loops_since_full_pass_ = 0, loops_ = 0;
  std::shared_ptr<const PoseGraph> inliers_;
  uint64_t inliers_version_ = 0;
};

}  // namespace atlas::mapping
