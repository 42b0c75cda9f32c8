// Loops of a pose graph (thesis 4.7): nodes near which the robot may be again, and nodes that look alike,
// tried by registering what they saw.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mapping/slam/loop_check.h"
#include "mapping/slam/places.h"
#include "mapping/slam/pose_graph.h"
#include "mapping/slam/slam_params.h"

namespace atlas::mapping {

struct Loop {
  uint32_t from = 0, to = 0;
  core::Pose T_from_to = core::Pose::Identity();
  core::Mat6 information = core::Mat6::Identity();
};

/// What a node saw, in the frame of its sensor at the node's first revolution, and where that was on the
/// node.
struct NodeCloud {
  std::vector<core::Vec3f> first_lidar;  ///< returns of that revolution: what its beams passed
  std::vector<core::Vec3f> later_lidar;  ///< of others, where sparse rows leave gaps
  core::Pose T_node_lidar = core::Pose::Identity();
};

/// What is kept of a node, so that a later session finds loops to it: all in the frame of its sensor.
struct NodeMemory {
  core::Pose T_node_lidar = core::Pose::Identity();
  double voxel_m = 0.1;                     ///< of the points, one a voxel
  std::vector<core::Vec3f> points_lidar;    ///< thinned, of all its revolutions
  std::vector<uint16_t> nearest, farthest;  ///< RangeView's
  std::vector<PlaceDescriptor::Cell> plan;  ///< PlaceDescriptor's
};

class LoopSearch {
 public:
  explicit LoopSearch(const SlamParams& params) : params_(params) {}

  /// One cloud a node, in their order. `T_map_node` need be right in roll and pitch alone.
  void Add(const NodeCloud& cloud, const core::Pose& T_map_node);
  /// A node of an earlier session. Call before any Add; the first node added begins a session of its own, of
  /// which nothing tells where it lies to what is recalled but loops.
  void Recall(const NodeMemory& node, const core::Pose& T_map_node);
  /// Of all nodes, in their order.
  std::vector<NodeMemory> Memory() const;
  /// From the latest node to older ones. `inliers`: the graph without false loops.
  /// @pre a cloud for each node.
  std::vector<Loop> FromLatest(const PoseGraph& inliers) const;
  /// From the latest node to recalled ones by their looks alone, where it is not known how they lie to it.
  std::vector<Loop> ToRecalled(const PoseGraph& graph) const;

 private:
  /// A node to be tried.
  struct Candidate {
    uint32_t node;
    double distance_m;
    std::optional<core::Mat6> covariance;           ///< of its pose to the latest one's, where it is known
    std::vector<core::Pose> T_lidar_latest_starts;  ///< the latest's sensor in its own, where plans agree
  };
  /// What was seen from a node.
  struct View {
    LoopScan scan;
    core::Pose T_node_lidar;
    core::Mat3 R_level_lidar;
  };

  /// Nearest first: within the radius, widened by how little is known of where the two are to each other.
  std::vector<Candidate> Near(const PoseGraph& inliers, const std::vector<double>& way_m) const;
  /// The most alike first.
  std::vector<Candidate> Alike(const std::vector<double>& way_m) const;
  std::optional<Loop> Verify(const Candidate& candidate, const PoseGraph& inliers) const;
  /// Metres along odometry from each node to the latest; infinite to those of an earlier session.
  std::vector<double> WaysToLatest(const std::vector<core::Pose>& T_map_node) const;

  SlamParams params_;
  size_t recalled_ = 0;  ///< nodes
  std::vector<View> views_;
  PlaceDatabase places_;
  PlaceDescriptor latest_place_;
};

}  // namespace atlas::mapping
