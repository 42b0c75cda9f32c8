#include "mapping/slam/chordal_start.h"

#include <Eigen/SparseCholesky>
#include <optional>

namespace atlas::mapping {
namespace {

using core::Mat3;
using core::Pose;
using Triplets = std::vector<Eigen::Triplet<double>>;

/// Where the unknowns of each node begin, by blocks; -1 for fixed ones.
struct FreeNodes {
  std::vector<int> slot;
  int count = 0;

  explicit FreeNodes(const PoseGraph& graph) : slot(graph.size(), -1) {
    const std::vector<bool> fixed = FixedNodes(graph);
    for (uint32_t node = 0; node < graph.size(); ++node) {
      if (!fixed[node]) slot[node] = count++;
    }
  }
};

/// The rotation nearest to M in the Frobenius norm.
Mat3 NearestRotation(const Mat3& M) {
  const Eigen::JacobiSVD<Mat3> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Mat3 U = svd.matrixU(), V = svd.matrixV();
  core::Vec3 sign(1.0, 1.0, (U * V.transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  return U * sign.asDiagonal() * V.transpose();
}

std::optional<Eigen::MatrixXd> Solve(const Triplets& triplets, const Eigen::MatrixXd& right) {
  Eigen::SparseMatrix<double> A(right.rows(), right.rows());
  A.setFromTriplets(triplets.begin(), triplets.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> ldlt(A);
  if (ldlt.info() != Eigen::Success) return std::nullopt;
  Eigen::MatrixXd x = ldlt.solve(right);
  if (!x.allFinite()) return std::nullopt;
  return x;
}

void AddBlock(int row, int col, const Mat3& block, Triplets* triplets) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (block(i, j) != 0.0) triplets->emplace_back(3 * row + i, 3 * col + j, block(i, j));
    }
  }
}

/// Normal equations of sum kappa |R_j^T - R_ij^T R_i^T|^2, linear in the transposed rotations: three
/// right-hand sides, one for each row of R.
std::optional<Eigen::MatrixXd> RelaxedRotations(const PoseGraph& graph, const FreeNodes& free) {
  Triplets triplets;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(3 * free.count, 3);
  for (const PoseEdge& edge : graph.edges) {
    const double kappa = ChordalWeightsOf(edge, graph.planar).kappa;
    const Mat3 R_ij = edge.T_from_to.linear();
    const int i = free.slot[edge.from], j = free.slot[edge.to];
    if (i >= 0) AddBlock(i, i, kappa * Mat3::Identity(), &triplets);
    if (j >= 0) AddBlock(j, j, kappa * Mat3::Identity(), &triplets);
    if (i >= 0 && j >= 0) {
      AddBlock(j, i, -kappa * R_ij.transpose(), &triplets);
      AddBlock(i, j, -kappa * R_ij, &triplets);
    } else if (i >= 0) {
      right.middleRows<3>(3 * i) += kappa * R_ij * graph.T_map_node[edge.to].linear().transpose();
    } else if (j >= 0) {
      right.middleRows<3>(3 * j) +=
          kappa * R_ij.transpose() * graph.T_map_node[edge.from].linear().transpose();
    }
  }
  return Solve(triplets, right);
}

/// Normal equations of sum tau |t_j - t_i - R_i t_ij|^2.
std::optional<Eigen::MatrixXd> Translations(const PoseGraph& graph, const FreeNodes& free,
                                            const std::vector<Pose>& poses) {
  Triplets triplets;
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(free.count, 3);
  for (const PoseEdge& edge : graph.edges) {
    const double tau = ChordalWeightsOf(edge, graph.planar).tau;
    const Eigen::RowVector3d step = (poses[edge.from].linear() * edge.T_from_to.translation()).transpose();
    const int i = free.slot[edge.from], j = free.slot[edge.to];
    if (i >= 0) {
      triplets.emplace_back(i, i, tau);
      right.row(i) -= tau * step;
      if (j < 0) right.row(i) += tau * poses[edge.to].translation().transpose();
    }
    if (j >= 0) {
      triplets.emplace_back(j, j, tau);
      right.row(j) += tau * step;
      if (i < 0) right.row(j) += tau * poses[edge.from].translation().transpose();
    }
    if (i >= 0 && j >= 0) {
      triplets.emplace_back(i, j, -tau);
      triplets.emplace_back(j, i, -tau);
    }
  }
  return Solve(triplets, right);
}

}  // namespace

std::vector<Pose> ChordalStart(const PoseGraph& graph) {
  std::vector<Pose> poses = graph.T_map_node;
  const FreeNodes free(graph);
  if (free.count == 0) return poses;
  const auto rotations = RelaxedRotations(graph, free);
  if (!rotations) return poses;
  for (uint32_t node = 0; node < graph.size(); ++node) {
    if (free.slot[node] < 0) continue;
    const Mat3 R = NearestRotation(rotations->middleRows<3>(3 * free.slot[node]).transpose());
    poses[node].linear() = graph.planar ? core::RotationFromYawPitchRoll(core::YawOf(R), 0.0, 0.0) : R;
  }
  const auto translations = Translations(graph, free, poses);
  if (!translations) return graph.T_map_node;
  for (uint32_t node = 0; node < graph.size(); ++node) {
    if (free.slot[node] >= 0) poses[node].translation() = translations->row(free.slot[node]).transpose();
  }
  return poses;
}

}  // namespace atlas::mapping
