#include "mapping/slam/graph_covariance.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "mapping/slam/edge_terms.h"

namespace atlas::mapping {
namespace {

using core::Mat6;
using core::Pose;
using RowMajor12 = Eigen::Matrix<double, Eigen::Dynamic, 12, Eigen::RowMajor>;

/// L^-1 B for a unit lower triangular L whose diagonal is not stored. Rows of B that are still zero are
/// skipped: of a few unit columns only their paths to the root of the elimination tree fill in.
void SolveLower(const Eigen::SparseMatrix<double>& L, RowMajor12* B) {
  for (int k = 0; k < L.outerSize(); ++k) {
    const Eigen::Matrix<double, 1, 12> row = B->row(k);
    if ((row.array() == 0.0).all()) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator it(L, k); it; ++it) {
      if (it.row() > k) B->row(it.row()) -= it.value() * row;
    }
  }
}

}  // namespace

std::unique_ptr<const GraphCovariance> GraphCovariance::Of(const PoseGraph& graph) {
  std::unique_ptr<const GraphCovariance> covariance(new GraphCovariance(graph));
  if (covariance->size_ == 0) return covariance;
  if (covariance->factor_.info() != Eigen::Success) return nullptr;
  const Eigen::VectorXd D = covariance->factor_.vectorD();
  // A free direction leaves a pivot at the level of rounding.
  if (!D.allFinite() || !(D.minCoeff() > 1e-14 * D.maxCoeff())) return nullptr;
  return covariance;
}

GraphCovariance::GraphCovariance(const PoseGraph& graph)
    : T_map_node_(graph.T_map_node),
      rows_(graph.planar ? std::vector<int>{0, 1, 5} : std::vector<int>{0, 1, 2, 3, 4, 5}),
      first_row_(graph.size(), -1) {
  const std::vector<bool> fixed = FixedNodes(graph);
  for (uint32_t node = 0; node < graph.size(); ++node) {
    if (fixed[node]) continue;
    first_row_[node] = size_;
    size_ += static_cast<int>(rows_.size());
  }
  if (size_ > 0) factor_.compute(Hessian(graph));
}

Eigen::SparseMatrix<double> GraphCovariance::Hessian(const PoseGraph& graph) const {
  std::vector<Eigen::Triplet<double>> triplets;
  triplets.reserve(graph.edges.size() * 4 * rows_.size() * rows_.size());
  const auto add = [&](uint32_t a, uint32_t b, const Mat6& block) {
    if (first_row_[a] < first_row_[b] || first_row_[b] < 0) return;  // the lower triangle
    for (size_t i = 0; i < rows_.size(); ++i) {
      for (size_t j = 0; j < rows_.size(); ++j)
        triplets.emplace_back(first_row_[a] + static_cast<int>(i), first_row_[b] + static_cast<int>(j),
                              block(rows_[i], rows_[j]));
    }
  };
  for (const PoseEdge& edge : graph.edges) {
    const EdgeTerms<6> J = LogMapTerms(edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]);
    const Mat6 from = edge.information * J.by_from, to = edge.information * J.by_to;
    add(edge.from, edge.from, J.by_from.transpose() * from);
    add(edge.to, edge.to, J.by_to.transpose() * to);
    add(edge.from, edge.to, J.by_from.transpose() * to);
    add(edge.to, edge.from, J.by_to.transpose() * from);
  }
  Eigen::SparseMatrix<double> H(size_, size_);
  H.setFromTriplets(triplets.begin(), triplets.end());
  return H;
}

Mat12 GraphCovariance::Joint(uint32_t i, uint32_t j) const {
  assert(i < T_map_node_.size() && j < T_map_node_.size());
  Mat12 joint = Mat12::Zero();
  if (size_ == 0) return joint;
  // With P H P^T = L D L^T and unit columns B: B^T H^-1 B = Y^T D^-1 Y, Y = L^-1 P B.
  RowMajor12 Y = RowMajor12::Zero(size_, 12);
  const auto& position = factor_.permutationP().indices();
  for (const auto& [node, column] : {std::pair{i, 0}, std::pair{j, 6}}) {
    if (first_row_[node] < 0) continue;
    for (size_t k = 0; k < rows_.size(); ++k)
      Y(position[first_row_[node] + static_cast<int>(k)], column + rows_[k]) = 1.0;
  }
  SolveLower(factor_.matrixL().nestedExpression(), &Y);
  const Eigen::VectorXd D = factor_.vectorD();
  for (int k = 0; k < size_; ++k) {
    const Eigen::Matrix<double, 1, 12> y = Y.row(k);
    if ((y.array() != 0.0).any()) joint.noalias() += y.transpose() * (y / D[k]);
  }
  return joint;
}

Mat6 GraphCovariance::Marginal(uint32_t node) const {
  return Joint(node, node).topLeftCorner<6, 6>();
}

Mat6 GraphCovariance::Relative(uint32_t i, uint32_t j) const {
  return RelativeCovariance(Joint(i, j), T_map_node_[i], T_map_node_[j]);
}

Mat6 RelativeCovariance(const Mat12& joint, const Pose& T_map_i, const Pose& T_map_j) {
  const Mat6 A = core::Adjoint(T_map_j.inverse() * T_map_i);
  const Mat6 cross = A * joint.topRightCorner<6, 6>();
  const Mat6 sum = A * joint.topLeftCorner<6, 6>() * A.transpose() + joint.bottomRightCorner<6, 6>() - cross -
                   cross.transpose();
  return 0.5 * (sum + sum.transpose());
}

double GreatestTranslationSigma(const Mat6& covariance) {
  const core::Mat3 translation = covariance.topLeftCorner<3, 3>();
  const double largest =
      Eigen::SelfAdjointEigenSolver<core::Mat3>(translation, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  return std::sqrt(std::max(largest, 0.0));
}

}  // namespace atlas::mapping
