#include "mapping/slam/pose_graph.h"

#include <algorithm>
#include <numeric>

namespace atlas::mapping {
namespace {

using core::Mat3;
using core::Pose;
using core::Vec3;
using core::Vec6;

double ChordalErrorOf(const PoseEdge& edge, const PoseGraph& graph) {
  const ChordalWeights w = ChordalWeightsOf(edge, graph.planar);
  const Pose &T_i = graph.T_map_node[edge.from], &T_j = graph.T_map_node[edge.to];
  const Pose predicted = T_i * edge.T_from_to;
  return w.kappa * (T_j.linear() - predicted.linear()).squaredNorm() +
         w.tau * (T_j.translation() - predicted.translation()).squaredNorm();
}

double G2oErrorOf(const PoseEdge& edge, const PoseGraph& graph) {
  const Pose E = edge.T_from_to.inverse() * graph.T_map_node[edge.from].inverse() * graph.T_map_node[edge.to];
  Eigen::Quaterniond q(E.linear());
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  Vec6 e;
  e << E.translation(), q.vec();
  if (graph.planar) e[5] = core::YawOf(E.linear());
  return e.dot(edge.information * e);
}

}  // namespace

Vec6 LogError(const PoseEdge& edge, const Pose& T_map_from, const Pose& T_map_to) {
  return core::Log(edge.T_from_to.inverse() * (T_map_from.inverse() * T_map_to));
}

double SquaredError(const PoseEdge& edge, const Pose& T_map_from, const Pose& T_map_to) {
  const Vec6 e = LogError(edge, T_map_from, T_map_to);
  return e.dot(edge.information * e);
}

ChordalWeights ChordalWeightsOf(const PoseEdge& edge, bool planar) {
  const auto& W = edge.information;
  if (planar) return {W(5, 5), 2.0 / W.topLeftCorner<2, 2>().inverse().trace()};
  const Mat3 translation = W.topLeftCorner<3, 3>(), rotation = W.bottomRightCorner<3, 3>();
  return {3.0 / (2.0 * rotation.inverse().trace()), 3.0 / translation.inverse().trace()};
}

double LogMapCost(const PoseGraph& graph) {
  double sum = 0.0;
  for (const PoseEdge& edge : graph.edges)
    sum += SquaredError(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]);
  return 0.5 * sum;
}

double ChordalCost(const PoseGraph& graph) {
  double sum = 0.0;
  for (const PoseEdge& edge : graph.edges) sum += ChordalErrorOf(edge, graph);
  return sum;
}

double G2oChi2(const PoseGraph& graph) {
  double sum = 0.0;
  for (const PoseEdge& edge : graph.edges) sum += G2oErrorOf(edge, graph);
  return sum;
}

std::vector<bool> FixedNodes(const PoseGraph& graph) {
  std::vector<bool> fixed(graph.size(), false);
  for (const uint32_t node : graph.fixed) fixed[node] = true;
  if (graph.fixed.empty()) fixed[0] = true;
  return fixed;
}

NodeSets::NodeSets(uint32_t count) : parent_(count) {
  std::iota(parent_.begin(), parent_.end(), 0u);
}

uint32_t NodeSets::Root(uint32_t node) {
  while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
  return node;
}

bool NodeSets::Join(uint32_t a, uint32_t b) {
  a = Root(a);
  b = Root(b);
  parent_[std::max(a, b)] = std::min(a, b);
  return a != b;
}

std::vector<uint32_t> ComponentsOf(const PoseGraph& graph) {
  NodeSets sets(graph.size());
  for (const PoseEdge& edge : graph.edges) sets.Join(edge.from, edge.to);
  for (const uint32_t node : graph.fixed) sets.Join(graph.fixed.front(), node);
  std::vector<uint32_t> component(graph.size());
  uint32_t count = 0;
  // A root is the lowest node of its component, so it comes first.
  for (uint32_t node = 0; node < graph.size(); ++node) {
    const uint32_t r = sets.Root(node);
    component[node] = r == node ? count++ : component[r];
  }
  return component;
}

PoseGraph WithoutEdges(const PoseGraph& graph, const std::vector<size_t>& rejected) {
  PoseGraph kept{graph.T_map_node, {}, graph.fixed, graph.planar};
  auto next = rejected.begin();
  for (size_t k = 0; k < graph.edges.size(); ++k) {
    if (next != rejected.end() && *next == k) {
      ++next;
    } else {
      kept.edges.push_back(graph.edges[k]);
    }
  }
  return kept;
}

std::vector<Pose> ChainedPoses(const PoseGraph& graph) {
  std::vector<const PoseEdge*> incoming(graph.size(), nullptr);
  for (const PoseEdge& edge : graph.edges) {
    const bool is_odometry = edge.kind == EdgeKind::kOdometry && edge.from < edge.to;
    if (is_odometry && !incoming[edge.to]) incoming[edge.to] = &edge;
  }
  std::vector<Pose> chained = graph.T_map_node;
  if (graph.size() == 0) return chained;
  const std::vector<bool> fixed = FixedNodes(graph);
  for (uint32_t node = 0; node < graph.size(); ++node) {
    if (incoming[node] && !fixed[node])
      chained[node] = chained[incoming[node]->from] * incoming[node]->T_from_to;
  }
  return chained;
}

}  // namespace atlas::mapping
