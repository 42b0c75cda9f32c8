#include "mapping/slam/graph_poses.h"

#include <algorithm>
#include <cmath>

namespace atlas::mapping {

using core::Mat6;

SolvedGraph::SolvedGraph(std::shared_ptr<const PoseGraph> inliers) : inliers_(std::move(inliers)) {
  for (const PoseEdge& edge : inliers_->edges) {
    if (edge.kind == EdgeKind::kLoop)
      loops_.emplace_back(std::min(edge.from, edge.to), std::max(edge.from, edge.to));
  }
}

std::optional<Mat6> SolvedGraph::Relative(uint32_t i, uint32_t j) const {
  std::call_once(factored_, [this] { covariance_ = GraphCovariance::Of(*inliers_); });
  return covariance_ ? std::optional(covariance_->Relative(i, j)) : std::nullopt;
}

std::optional<double> GraphPoses::RelativeSigmaM(core::KeyframeId a, core::KeyframeId b) const {
  const uint32_t i = std::min(a, b), j = std::max(a, b), solved = solved_->size();
  assert(j < T_map_node_.size());
  if (i == j) return 0.0;
  // Behind the solved nodes hangs a chain that no other edge touches: its steps add to what is known of the
  // node that it hangs on, each seen from the end of the next.
  uint32_t at = std::max(i, std::min(j, solved - 1));
  Mat6 covariance = Mat6::Zero();
  if (at > i) {
    const auto known = solved_->Relative(i, at);
    if (!known) return std::nullopt;
    covariance = *known;
  }
  while (at < j) {
    const NodeStep& step = steps_[++at - solved];
    const Mat6 from_previous = core::Adjoint(step.T_previous_node.inverse());
    covariance = from_previous * covariance * from_previous.transpose() + step.covariance;
  }
  Mat6 of_j = covariance;
  if (a > b) {  // T_a_b = T_i_j^-1: its perturbation is the other's, seen from i
    const Mat6 turned = core::Adjoint(T_map_node_[i].inverse() * T_map_node_[j]);
    of_j = turned * covariance * turned.transpose();
  }
  return GreatestTranslationSigma(of_j);
}

}  // namespace atlas::mapping
