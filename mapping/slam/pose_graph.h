// Pose graphs: nodes, measured relative poses between them, and what a graph costs.
//
// Three conventions of cost are in use, with E = T_from_to^-1 T_map_from^-1 T_map_to and information W
// ([translation; rotation]):
//   log-map  1/2 sum e^T W e, e = Log(E): what is minimised here and by GTSAM
//   chordal  sum kappa |R_to - R_from R|_F^2 + tau |t_to - t_from - R_from t|^2 without 1/2, isotropic: the
//            cost whose optima SE-Sync publishes; kappa = 3 / (2 tr W_R^-1), tau = 3 / tr W_t^-1 in space,
//            kappa = W_33, tau = 2 / tr W_t^-1 in the plane
//   g2o      chi2 = sum e^T W e, e = (t, vec q) of E in space, (t, yaw) in the plane
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/se3.h"

namespace atlas::mapping {

enum class EdgeKind : uint8_t { kOdometry, kLoop };

/// The relative pose T_from_to as measured. Its information is of Log in [translation; rotation].
struct PoseEdge {
  uint32_t from = 0, to = 0;
  core::Pose T_from_to = core::Pose::Identity();
  core::Mat6 information = core::Mat6::Identity();
  EdgeKind kind = EdgeKind::kOdometry;
};

struct PoseGraph {
  std::vector<core::Pose> T_map_node = {};
  std::vector<PoseEdge> edges = {};
  std::vector<uint32_t> fixed = {};  ///< nodes that stay where they are; empty: the first one
  /// All poses and edges lie in the plane z = 0 and turn about z: three degrees of freedom a node. Of an
  /// information matrix only x, y and yaw count.
  bool planar = false;

  uint32_t size() const { return static_cast<uint32_t>(T_map_node.size()); }
};

/// Log(T_from_to^-1 T_map_from^-1 T_map_to).
core::Vec6 LogError(const PoseEdge& edge, const core::Pose& T_map_from, const core::Pose& T_map_to);
/// e^T W e of the log-map error.
double SquaredError(const PoseEdge& edge, const core::Pose& T_map_from, const core::Pose& T_map_to);

/// The isotropic weights that SE-Sync takes from an information matrix.
struct ChordalWeights {
  double kappa = 0.0, tau = 0.0;
};
ChordalWeights ChordalWeightsOf(const PoseEdge& edge, bool planar);

double LogMapCost(const PoseGraph& graph);
double ChordalCost(const PoseGraph& graph);
double G2oChi2(const PoseGraph& graph);

/// One flag a node: whether it stays where it is. @pre graph.size() > 0.
std::vector<bool> FixedNodes(const PoseGraph& graph);

/// Nodes that are known to be connected (union-find). The root of a set is its lowest node.
class NodeSets {
 public:
  explicit NodeSets(uint32_t count);
  uint32_t Root(uint32_t node);
  /// Whether the two were apart.
  bool Join(uint32_t a, uint32_t b);

 private:
  std::vector<uint32_t> parent_;
};

/// For each node a number of its connected component, from 0 in order of their first nodes. Fixed nodes count
/// as connected to each other.
std::vector<uint32_t> ComponentsOf(const PoseGraph& graph);

/// The graph without some of its edges. @pre `rejected` ascends.
PoseGraph WithoutEdges(const PoseGraph& graph, const std::vector<size_t>& rejected);

/// Poses along the odometry edges from where their chains begin: each node reached from a lower one by an
/// odometry edge is placed by the first such edge, all others keep their pose.
std::vector<core::Pose> ChainedPoses(const PoseGraph& graph);

}  // namespace atlas::mapping
