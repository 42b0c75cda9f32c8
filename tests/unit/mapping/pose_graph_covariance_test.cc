#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <vector>

#include "mapping/slam/graph_covariance.h"
#include "mapping/slam/graph_solver.h"
#include "mapping/slam/room_graph.h"

namespace atlas::tests {
namespace {

using core::Mat6;
using core::Pose;
using core::Vec6;
using mapping::GraphCovariance;
using mapping::Mat12;
using mapping::PoseEdge;
using mapping::PoseGraph;

/// A solved graph of two laps with loops.
PoseGraph SolvedRooms(bool planar, uint64_t seed = 1) {
  PoseGraph graph = mapping::MakeRoomGraph(260, 7, core::Rng(seed), planar).graph;
  mapping::Optimise(&graph);
  return graph;
}

double RelativeDifference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return (a - b).norm() / b.norm();
}

/// The whole covariance by differences of the error and dense inversion, node 0 held; zero rows where planar.
Eigen::MatrixXd DenseCovariance(const PoseGraph& graph) {
  const int n = static_cast<int>(graph.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  constexpr double kStep = 1e-6;
  for (const PoseEdge& edge : graph.edges) {
    const Pose &T_i = graph.T_map_node[edge.from], &T_j = graph.T_map_node[edge.to];
    Eigen::Matrix<double, 6, 12> J;
    for (int k = 0; k < 6; ++k) {
      const Pose d = core::Exp(kStep * Vec6::Unit(k)), b = d.inverse();
      J.col(k) =
          (mapping::LogError(edge, T_i * d, T_j) - mapping::LogError(edge, T_i * b, T_j)) / (2 * kStep);
      J.col(6 + k) =
          (mapping::LogError(edge, T_i, T_j * d) - mapping::LogError(edge, T_i, T_j * b)) / (2 * kStep);
    }
    const Mat12 block = J.transpose() * edge.information * J;
    const int at[2] = {static_cast<int>(6 * edge.from), static_cast<int>(6 * edge.to)};
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c) H.block<6, 6>(at[r], at[c]) += block.block<6, 6>(6 * r, 6 * c);
    }
  }
  std::vector<int> free;
  for (int row = 6; row < 6 * n; ++row) {
    if (!graph.planar || row % 6 < 2 || row % 6 == 5) free.push_back(row);
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(6 * n, 6 * n);
  const Eigen::MatrixXd inverse = Eigen::MatrixXd(H(free, free)).inverse();
  covariance(free, free) = inverse;
  return covariance;
}

TEST(GraphCovariance, EqualsDenseInversion) {
  for (const bool planar : {false, true}) {
    PoseGraph graph = mapping::MakeRoomGraph(130, 3, core::Rng(2), planar).graph;
    mapping::Optimise(&graph);
    const Eigen::MatrixXd dense = DenseCovariance(graph);
    const auto covariance = GraphCovariance::Of(graph);
    ASSERT_NE(covariance, nullptr);
    for (const auto& [i, j] :
         {std::pair{40u, 111u}, std::pair{128u, 3u}, std::pair{1u, 2u}, std::pair{0u, 77u}}) {
      Mat12 expected;
      expected << dense.block<6, 6>(6 * i, 6 * i), dense.block<6, 6>(6 * i, 6 * j),
          dense.block<6, 6>(6 * j, 6 * i), dense.block<6, 6>(6 * j, 6 * j);
      EXPECT_LT(RelativeDifference(covariance->Joint(i, j), expected), 1e-6) << i << " " << j;
    }
    EXPECT_LT(RelativeDifference(covariance->Marginal(90), dense.block<6, 6>(540, 540)), 1e-6);
    EXPECT_EQ(covariance->Marginal(0), Mat6::Zero());
  }
}

TEST(GraphCovariance, RelativeCovarianceEqualsReanchoredMarginal) {
  for (const bool planar : {false, true}) {
    const PoseGraph graph = SolvedRooms(planar);
    const auto covariance = GraphCovariance::Of(graph);
    for (const auto& [i, j] : {std::pair{50u, 200u}, std::pair{259u, 13u}, std::pair{0u, 99u}}) {
      PoseGraph reanchored = graph;
      reanchored.fixed = {i};
      const auto other = GraphCovariance::Of(reanchored);
      EXPECT_LT(RelativeDifference(covariance->Relative(i, j), other->Marginal(j)), 1e-9) << i << " " << j;
    }
  }
}

TEST(GraphCovariance, RelativeCovarianceDoesNotDependOnWhereTheMapIs) {
  PoseGraph graph = SolvedRooms(false);
  const Mat6 before = GraphCovariance::Of(graph)->Relative(30, 170);
  const Pose T = core::Exp((Vec6() << 5, -7, 2, 0.3, 0.8, -1.1).finished());
  for (Pose& T_map_node : graph.T_map_node) T_map_node = T * T_map_node;
  EXPECT_LT(RelativeDifference(GraphCovariance::Of(graph)->Relative(30, 170), before), 1e-9);
}

TEST(GraphCovariance, SamplesOfTheJointSpreadAsTheRelativeOneSays) {
  const PoseGraph graph = SolvedRooms(false);
  const auto covariance = GraphCovariance::Of(graph);
  const uint32_t i = 60, j = 180;
  const Mat12 joint = covariance->Joint(i, j);
  const Eigen::Matrix<double, 12, 12> root = joint.llt().matrixL();
  const Pose T_i = graph.T_map_node[i], T_j = graph.T_map_node[j], mean = T_i.inverse() * T_j;
  core::Rng rng(11);
  Mat6 sum = Mat6::Zero();
  constexpr int kSamples = 10000;
  for (int k = 0; k < kSamples; ++k) {
    Eigen::Matrix<double, 12, 1> z;
    for (int row = 0; row < 12; ++row) z[row] = rng.Normal();
    const Eigen::Matrix<double, 12, 1> xi = root * z;
    const Pose sample = (T_i * core::Exp(xi.head<6>())).inverse() * (T_j * core::Exp(xi.tail<6>()));
    const Vec6 d = core::Log(mean.inverse() * sample);
    sum += d * d.transpose() / kSamples;
  }
  EXPECT_LT(RelativeDifference(sum, covariance->Relative(i, j)), 0.05);
  // Without the cross term it would be far off.
  Mat12 apart = joint;
  apart.topRightCorner<6, 6>().setZero();
  EXPECT_GT(mapping::RelativeCovariance(apart, T_i, T_j).trace(), 1.5 * covariance->Relative(i, j).trace());
}

/// A residual of an edge by differences, for Ceres to find the covariance itself.
struct NumericEdge {
  PoseEdge edge;
  Pose T_from, T_to;
  bool operator()(const double* from, const double* to, double* residual) const {
    const Vec6 e = mapping::LogError(edge, T_from * core::Exp(Eigen::Map<const Vec6>(from)),
                                     T_to * core::Exp(Eigen::Map<const Vec6>(to)));
    Eigen::Map<Vec6>(residual, 6) = Mat6(edge.information.llt().matrixU()) * e;
    return true;
  }
};

TEST(GraphCovariance, EqualsThatOfCeres) {
  PoseGraph graph = mapping::MakeRoomGraph(130, 3, core::Rng(5)).graph;
  mapping::Optimise(&graph);
  std::vector<Vec6> tangent(graph.size(), Vec6::Zero());
  ceres::Problem problem;
  for (const PoseEdge& edge : graph.edges) {
    problem.AddResidualBlock(
        new ceres::NumericDiffCostFunction<NumericEdge, ceres::CENTRAL, 6, 6, 6>(
            new NumericEdge{edge, graph.T_map_node[edge.from], graph.T_map_node[edge.to]}),
        nullptr, tangent[edge.from].data(), tangent[edge.to].data());
  }
  problem.SetParameterBlockConstant(tangent[0].data());
  const std::vector<std::pair<const double*, const double*>> blocks = {
      {tangent[20].data(), tangent[110].data()}};
  ceres::Covariance oracle{ceres::Covariance::Options()};
  ASSERT_TRUE(oracle.Compute(blocks, &problem));
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> cross;
  ASSERT_TRUE(oracle.GetCovarianceBlock(tangent[20].data(), tangent[110].data(), cross.data()));
  const Mat12 joint = GraphCovariance::Of(graph)->Joint(20, 110);
  EXPECT_LT(RelativeDifference(joint.topRightCorner<6, 6>(), cross), 1e-5);
}

TEST(GraphCovariance, NodesThatNothingHoldsHaveNone) {
  PoseGraph graph = SolvedRooms(false);
  graph.T_map_node.push_back(Pose::Identity());
  EXPECT_EQ(GraphCovariance::Of(graph), nullptr);
}

TEST(GraphCovariance, GreatestSigmaIsThatOfTranslationInMetres) {
  Mat6 covariance = Mat6::Identity() * 100.0;
  covariance.topLeftCorner<3, 3>() << 0.02, 0.02, 0, 0.02, 0.02, 0, 0, 0, 0.03;
  EXPECT_NEAR(mapping::GreatestTranslationSigma(covariance), 0.2, 1e-12);
}

}  // namespace
}  // namespace atlas::tests
