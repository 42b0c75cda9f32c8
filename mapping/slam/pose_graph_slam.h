// The pose graph of a robot on its way: nodes come one by one, loops now and then.
#pragma once

#include <vector>

#include "mapping/slam/robust_graph.h"

namespace atlas::mapping {

/// What a full robust solve found, for a graph as it was when it began.
struct FullPass {
  PoseGraph graph;
  RobustReport report;
};

/// SolveGnc on a copy: pure, so that any thread may run it while the robot goes on.
FullPass SolveFully(PoseGraph graph, const RobustOptions& options = {});

/// Between loops nodes are chained without solving; each loop is followed by a warm solve with dynamic
/// covariance scaling (Resolve), and a full pass is taken over when it comes (Adopt). Not for several threads
/// at once.
class PoseGraphSlam {
 public:
  explicit PoseGraphSlam(const core::Pose& T_map_first, const RobustOptions& options = {});
  /// Goes on from an earlier session's graph, of which no edge is false. @pre it has nodes.
  explicit PoseGraphSlam(PoseGraph earlier, const RobustOptions& options = {});

  /// A node one odometry step after the latest. Returns its number.
  uint32_t AddNode(const core::Pose& T_latest_node, const core::Mat6& information);
  /// A node that no edge leads to: the first of a session. Returns its number.
  uint32_t AddUnconnected(const core::Pose& T_map_node);
  /// Moves a node and all after it rigidly.
  void MoveFrom(uint32_t node, const core::Pose& T_map_node);
  /// A measured T_from_to. Changes no pose. Returns its number among the edges.
  /// @pre two different nodes that exist; finite pose, positive definite information.
  size_t AddLoop(uint32_t from, uint32_t to, const core::Pose& T_from_to, const core::Mat6& information);

  /// From the poses as they are; loops that the latest full pass rejected are left out. Where a loop that
  /// came since the latest Resolve stays open, it is tried once more with a loss of wider reach (SolveWide),
  /// which is kept if it fits all better. The report's rejected edges include them.
  RobustReport Resolve();

  /// Takes over what a full pass found on an earlier copy of graph(): its poses, and rigidly after its last
  /// node those that came since; its rejections. Loops since then stay, for the next Resolve.
  void Adopt(const FullPass& pass);

  const PoseGraph& graph() const { return graph_; }
  const std::vector<core::Pose>& T_map_node() const { return graph_.T_map_node; }
  /// Edges thought to be false, ascending.
  const std::vector<size_t>& rejected() const { return rejected_; }
  /// The graph without these, for GraphCovariance.
  PoseGraph InlierGraph() const { return WithoutEdges(graph_, rejected_); }
  /// Counts changes of poses other than new nodes.
  uint64_t version() const { return version_; }

 private:
  RobustOptions options_;
  PoseGraph graph_;
  std::vector<size_t> rejected_, rejected_by_full_pass_;
  size_t resolved_edges_ = 0;  ///< how many edges there were at the latest Resolve
  uint64_t version_ = 0;
};

}  // namespace atlas::mapping
