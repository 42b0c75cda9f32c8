// The back end of SLAM (thesis Fig. 4.6): takes finished nodes, finds their loops and says where all nodes
// lie.
//
// It is the same whatever thread runs it, as long as calls come one after another in the same order.
#pragma once

#include <memory>
#include <vector>

#include "mapping/slam/loop_search.h"
#include "mapping/slam/pose_graph_slam.h"
#include "mapping/slam/slam_memory.h"

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
  bool located = true;                            ///< it is known where this session lies in the map
};

/// A session that goes on from what an earlier one remembers is located where two loops to it agree; until
/// then its nodes lie to each other alone.
class SlamBackEnd {
 public:
  /// @param earlier  null: there is none, and the first node lies at T_map_first
  SlamBackEnd(const SlamParams& params, const core::Pose& T_map_first,
              const std::shared_ptr<const SlamMemory>& earlier = nullptr);

  /// Searches loops from the node; where one is found, all are solved for anew, fast.
  SolvedNodes Take(const FinishedNode& node);
  /// The full robust pass.
  SolvedNodes FullPass();

  const PoseGraphSlam& graph() const { return graph_; }
  SlamMemory Memory() const { return {graph_.InlierGraph(), search_.Memory()}; }

 private:
  SolvedNodes Solved();
  /// All loops found so far, once two of them agree; none before.
  std::vector<Loop> Locate();

  SlamParams params_;
  PoseGraphSlam graph_;
  LoopSearch search_;
  core::Pose T_map_first_;
  uint32_t begin_ = 0;  ///< the session's first node
  bool first_ = true, located_ = true;
  std::vector<Loop> waiting_;  ///< loops to an earlier session, while it is not located
  size_t loops_since_full_pass_ = 0, loops_ = 0;
  std::shared_ptr<const PoseGraph> inliers_;
  uint64_t inliers_version_ = 0;
};

}  // namespace atlas::mapping
