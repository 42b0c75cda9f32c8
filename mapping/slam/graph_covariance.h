// Covariances of a pose graph's nodes, absolute and relative to each other. All are of right perturbations,
// T = T_mean Exp(xi), in the order [translation; rotation]: m^2, m rad, rad^2.
#pragma once

#include <Eigen/SparseCholesky>
#include <memory>
#include <vector>

#include "mapping/slam/pose_graph.h"

namespace atlas::mapping {

using Mat12 = Eigen::Matrix<double, 12, 12>;

/// The inverse of the Gauss-Newton Hessian sum J^T W J at the graph's poses, factored once. Robust weights
/// would distort it: hand in the solved graph without its false loops.
class GraphCovariance {
 public:
  /// nullptr where the Hessian is singular: nodes that no edges hold.
  static std::unique_ptr<const GraphCovariance> Of(const PoseGraph& graph);

  /// In the frame of the fixed nodes, whose covariance is zero.
  core::Mat6 Marginal(uint32_t node) const;
  /// Of [i; j].
  Mat12 Joint(uint32_t i, uint32_t j) const;
  /// Of T_i_j, whichever node is fixed (thesis Eq. 4.13).
  core::Mat6 Relative(uint32_t i, uint32_t j) const;

 private:
  using Factor = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>;
  explicit GraphCovariance(const PoseGraph& graph);
  Eigen::SparseMatrix<double> Hessian(const PoseGraph& graph) const;

  std::vector<core::Pose> T_map_node_;
  std::vector<int> rows_;       ///< of a tangent vector that count
  std::vector<int> first_row_;  ///< of each node in the Hessian; -1 for fixed ones
  int size_ = 0;
  Factor factor_;
};

/// Covariance of T_i_j from that of [i; j] and the mean poses (thesis Eq. 4.13):
///   A S_i A^T + S_j - A S_ij - S_ij^T A^T, A = Ad(T_map_j^-1) Ad(T_map_i).
core::Mat6 RelativeCovariance(const Mat12& joint, const core::Pose& T_map_i, const core::Pose& T_map_j);

/// Greatest standard deviation of the translation, m: what the thesis compares with 0.2 m (4.9). The
/// eigenvalues themselves are m^2.
double GreatestTranslationSigma(const core::Mat6& covariance);

}  // namespace atlas::mapping
