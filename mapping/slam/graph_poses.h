// Keyframes that are the nodes of a pose graph, as it was solved at one moment.
#pragma once

#include <cassert>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/keyframe.h"
#include "mapping/slam/graph_covariance.h"

namespace atlas::mapping {

/// A graph as it was solved, for as many snapshots as begin with it. What it costs to say how sure its poses
/// are is spent when it is first asked for.
class SolvedGraph {
 public:
  /// @param inliers  without false loops
  explicit SolvedGraph(std::shared_ptr<const PoseGraph> inliers);

  uint32_t size() const { return inliers_->size(); }
  const PoseGraph& inliers() const { return *inliers_; }
  /// Of T_i_j; nothing where the graph does not hold its nodes. For any thread.
  std::optional<core::Mat6> Relative(uint32_t i, uint32_t j) const;
  const std::vector<std::pair<core::KeyframeId, core::KeyframeId>>& loops() const { return loops_; }

 private:
  std::shared_ptr<const PoseGraph> inliers_;
  std::vector<std::pair<core::KeyframeId, core::KeyframeId>> loops_;
  mutable std::once_flag factored_;
  mutable std::unique_ptr<const GraphCovariance> covariance_;
};

/// How a node was reached from the one before.
struct NodeStep {
  core::Pose T_previous_node = core::Pose::Identity();
  core::Mat6 covariance = core::Mat6::Zero();  ///< as in PoseEdge
};

class GraphPoses final : public core::PoseSource {
 public:
  /// @param solved  the nodes that the graph holds; those behind follow by `steps`, one a node
  GraphPoses(std::vector<core::Pose> T_map_node, uint64_t version, std::shared_ptr<const SolvedGraph> solved,
             const std::vector<NodeStep>& steps)
      : T_map_node_(std::move(T_map_node)),
        version_(version),
        solved_(std::move(solved)),
        steps_(steps.begin() + solved_->size(), steps.end()) {}
  core::Pose T_map_keyframe(core::KeyframeId keyframe) const override {
    assert(keyframe < T_map_node_.size());
    return T_map_node_[keyframe];
  }
  uint64_t version() const override { return version_; }
  core::KeyframeId latest() const override { return static_cast<core::KeyframeId>(T_map_node_.size() - 1); }
  std::optional<double> RelativeSigmaM(core::KeyframeId a, core::KeyframeId b) const override;
  const std::vector<std::pair<core::KeyframeId, core::KeyframeId>>& Loops() const override {
    return solved_->loops();
  }

 private:
  std::vector<core::Pose> T_map_node_;
  uint64_t version_;
  std::shared_ptr<const SolvedGraph> solved_;
  std::vector<NodeStep> steps_;  ///< of nodes behind the solved ones
};

}  // namespace atlas::mapping
