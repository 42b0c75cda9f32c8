// Loops by proximity (thesis 4.7): nodes near which the robot may be again, tried by registering their
// clouds.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "mapping/cloud/surface_cloud.h"
#include "mapping/slam/pose_graph.h"
#include "mapping/slam/slam_params.h"

namespace atlas::mapping {

struct Loop {
  uint32_t from = 0, to = 0;
  core::Pose T_from_to = core::Pose::Identity();
};

class LoopSearch {
 public:
  explicit LoopSearch(const SlamParams& params) : params_(params) {}

  /// What a node saw, in its own frame: one cloud a node, in their order.
  void AddCloud(SurfaceCloud cloud_node) { clouds_.push_back(std::move(cloud_node)); }
  /// From the latest node to older ones. `inliers`: the graph without false loops.
  /// @pre a cloud for each node.
  std::vector<Loop> FromLatest(const PoseGraph& inliers) const;

 private:
  struct Candidate {
    uint32_t node;
    double distance_m;
  };
  /// Nearest first: within the radius, widened by how little is known of where the two are to each other.
  std::vector<Candidate> Near(const PoseGraph& inliers) const;
  std::optional<Loop> Verify(uint32_t older, const PoseGraph& inliers) const;

  SlamParams params_;
  std::vector<SurfaceCloud> clouds_;
};

}  // namespace atlas::mapping
