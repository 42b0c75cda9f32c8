#include "mapping/slam/pose_graph_slam.h"

#include <algorithm>
#include <cassert>
#include <iterator>

#include "core/stopwatch.h"

namespace atlas::mapping {

using core::Pose;

FullPass SolveFully(PoseGraph graph, const RobustOptions& options) {
  FullPass pass{std::move(graph), {}};
  pass.report = SolveGnc(&pass.graph, options);
  return pass;
}

PoseGraphSlam::PoseGraphSlam(const Pose& T_map_first, const RobustOptions& options) : options_(options) {
  graph_.T_map_node.push_back(T_map_first);
}

PoseGraphSlam::PoseGraphSlam(PoseGraph earlier, const RobustOptions& options)
    : options_(options), graph_(std::move(earlier)), resolved_edges_(graph_.edges.size()) {
  assert(graph_.size() > 0);
}

uint32_t PoseGraphSlam::AddUnconnected(const Pose& T_map_node) {
  graph_.T_map_node.push_back(T_map_node);
  return graph_.size() - 1;
}

void PoseGraphSlam::MoveFrom(uint32_t node, const Pose& T_map_node) {
  const Pose T_new_old = T_map_node * graph_.T_map_node[node].inverse();
  for (uint32_t moved = node; moved < graph_.size(); ++moved)
    graph_.T_map_node[moved] = T_new_old * graph_.T_map_node[moved];
  ++version_;
}

uint32_t PoseGraphSlam::AddNode(const Pose& T_latest_node, const core::Mat6& information) {
  const uint32_t node = graph_.size();
  graph_.T_map_node.push_back(graph_.T_map_node.back() * T_latest_node);
  graph_.edges.push_back({node - 1, node, T_latest_node, information, EdgeKind::kOdometry});
  return node;
}

size_t PoseGraphSlam::AddLoop(uint32_t from, uint32_t to, const Pose& T_from_to,
                              const core::Mat6& information) {
  assert(from != to && from < graph_.size() && to < graph_.size());
  graph_.edges.push_back({from, to, T_from_to, information, EdgeKind::kLoop});
  return graph_.edges.size() - 1;
}

RobustReport PoseGraphSlam::Resolve() {
  const core::Stopwatch watch;
  const double cut = options_.CutOf(graph_);
  PoseGraph believed = WithoutEdges(graph_, rejected_by_full_pass_);
  const std::vector<Pose> start = believed.T_map_node;
  RobustReport report = SolveDcs(&believed, options_);
  // Edges that came since stand at the end of either graph.
  const size_t first_new = believed.edges.size() - (graph_.edges.size() - resolved_edges_);
  if (!report.rejected.empty() && report.rejected.back() >= first_new) {
    PoseGraph wide = believed;
    wide.T_map_node = start;
    const RobustReport other = SolveWide(&wide, options_);
    if (TruncatedCost(wide, cut) < TruncatedCost(believed, cut)) {
      believed = std::move(wide);
      report = other;
    }
  }
  graph_.T_map_node = std::move(believed.T_map_node);
  ++version_;
  resolved_edges_ = graph_.edges.size();
  const std::vector<size_t> above = LoopsAbove(graph_, cut);
  rejected_.clear();
  std::set_union(above.begin(), above.end(), rejected_by_full_pass_.begin(), rejected_by_full_pass_.end(),
                 std::back_inserter(rejected_));
  report.rejected = rejected_;
  report.solve.time_s = watch.seconds();
  return report;
}

void PoseGraphSlam::Adopt(const FullPass& pass) {
  const size_t known = pass.graph.T_map_node.size();
  assert(known > 0 && known <= graph_.T_map_node.size() && pass.graph.edges.size() <= graph_.edges.size());
  const Pose T_new_old = pass.graph.T_map_node.back() * graph_.T_map_node[known - 1].inverse();
  std::copy(pass.graph.T_map_node.begin(), pass.graph.T_map_node.end(), graph_.T_map_node.begin());
  for (size_t node = known; node < graph_.T_map_node.size(); ++node)
    graph_.T_map_node[node] = T_new_old * graph_.T_map_node[node];
  rejected_ = rejected_by_full_pass_ = pass.report.rejected;
  ++version_;
}

}  // namespace atlas::mapping
