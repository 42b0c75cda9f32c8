#include <gtest/gtest.h>

#include <array>

#include "mapping/slam/chordal_start.h"
#include "mapping/slam/edge_terms.h"
#include "mapping/slam/graph_solver.h"
#include "mapping/slam/room_graph.h"

namespace atlas::tests {
namespace {

using core::Mat3;
using core::Mat6;
using core::Pose;
using core::Vec3;
using core::Vec6;
using mapping::CostConvention;
using mapping::PoseEdge;
using mapping::PoseGraph;
using mapping::SolveReport;

constexpr std::array<CostConvention, 3> kConventions = {CostConvention::kLogMap, CostConvention::kChordal,
                                                        CostConvention::kG2o};

Mat6 RandomInformation(bool planar, core::Rng* rng) {
  Mat6 A;
  for (int k = 0; k < 36; ++k) A(k) = rng->Normal();
  Mat6 W = A * A.transpose() + Mat6::Identity();
  if (!planar) return W;
  for (const int row : {2, 3, 4}) {
    W.row(row).setZero();
    W.col(row).setZero();
    W(row, row) = 1.0;
  }
  return W;
}

/// A ring with chords, its measurements off by what `noise` says, its poses by ten times that.
PoseGraph NoisyRing(uint32_t nodes, const mapping::EdgeNoise& noise, bool planar, uint64_t seed) {
  core::Rng rng(seed);
  PoseGraph graph{.planar = planar};
  for (uint32_t k = 0; k < nodes; ++k)
    graph.T_map_node.push_back(
        core::PoseFromXyzYaw({3.0 * std::cos(0.6 * k), 3.0 * std::sin(0.6 * k), 0.0}, 0.9 * k));
  for (uint32_t k = 0; k < nodes; ++k) {
    for (const uint32_t ahead : {1u, 4u}) {
      PoseEdge edge{.from = k, .to = (k + ahead) % nodes};
      edge.T_from_to = graph.T_map_node[edge.from].inverse() * graph.T_map_node[edge.to] *
                       core::Exp(mapping::DrawError(noise, planar, &rng));
      edge.information = RandomInformation(planar, &rng);
      graph.edges.push_back(edge);
    }
  }
  for (uint32_t k = 1; k < nodes; ++k)
    graph.T_map_node[k] = graph.T_map_node[k] * core::Exp(10.0 * mapping::DrawError(noise, planar, &rng));
  return graph;
}

/// The cost after moving one node along one tangent direction.
double CostMoved(const PoseGraph& graph, CostConvention cost, uint32_t node, const Vec6& xi) {
  PoseGraph moved = graph;
  moved.T_map_node[node] = moved.T_map_node[node] * core::Exp(xi);
  return mapping::CostOf(moved, cost);
}

TEST(PoseGraphCost, ConventionsAreThoseOfTheirAuthors) {
  // One edge, off by 2 m along x and by the angle a about z, weights 3 (x), 5 (y), 7 (yaw).
  const double a = 0.3;
  PoseGraph graph{.planar = true};
  graph.T_map_node = {Pose::Identity(), core::PoseFromXyzYaw({2, 0, 0}, a)};
  PoseEdge edge{.from = 0, .to = 1};
  edge.information.diagonal() << 3, 5, 1, 1, 1, 7;
  graph.edges = {edge};
  EXPECT_NEAR(mapping::G2oChi2(graph), 3 * 4 + 7 * a * a, 1e-12);
  // |R - I|^2 = 4 (1 - cos a) in the plane.
  EXPECT_NEAR(mapping::ChordalCost(graph), 7 * 4 * (1 - std::cos(a)) + 2 / (1 / 3.0 + 1 / 5.0) * 4, 1e-12);
  // V^-1 t for SE(2): (a/2) [cot(a/2), 1; -1, cot(a/2)] t.
  const double x = a / 2 / std::tan(a / 2) * 2, y = -a / 2 * 2;
  EXPECT_NEAR(mapping::LogMapCost(graph), 0.5 * (3 * x * x + 5 * y * y + 7 * a * a), 1e-12);
  graph.planar = false;
  graph.edges[0].information.diagonal() << 3, 5, 6, 7, 8, 9;
  const double s = std::sin(a / 2);
  EXPECT_NEAR(mapping::G2oChi2(graph), 3 * 4 + 9 * s * s, 1e-12);
  EXPECT_NEAR(
      mapping::ChordalCost(graph),
      3 / (2 * (1 / 7.0 + 1 / 8.0 + 1 / 9.0)) * 4 * (1 - std::cos(a)) + 3 / (1 / 3.0 + 1 / 5.0 + 1 / 6.0) * 4,
      1e-12);
}

template <int kRows, typename Terms>
void ExpectDerivatives(const Terms& terms, const Pose& T_from, const Pose& T_to) {
  constexpr double kStep = 1e-6;
  const auto at = terms(T_from, T_to);
  for (int k = 0; k < 6; ++k) {
    const Pose ahead = core::Exp(kStep * Vec6::Unit(k)), back = ahead.inverse();
    const Eigen::Matrix<double, kRows, 1> by_from =
        (terms(T_from * ahead, T_to).error - terms(T_from * back, T_to).error) / (2 * kStep);
    const Eigen::Matrix<double, kRows, 1> by_to =
        (terms(T_from, T_to * ahead).error - terms(T_from, T_to * back).error) / (2 * kStep);
    EXPECT_LT((at.by_from.col(k) - by_from).norm(), 1e-7) << k;
    EXPECT_LT((at.by_to.col(k) - by_to).norm(), 1e-7) << k;
  }
}

TEST(PoseGraphTerms, DerivativesAreThoseOfDifferences) {
  core::Rng rng(5);
  const mapping::EdgeNoise wide{1.0, 0.4};
  for (int round = 0; round < 5; ++round) {
    const Pose T_from = core::Exp(mapping::DrawError(wide, false, &rng)),
               T_to = core::Exp(mapping::DrawError(wide, false, &rng));
    PoseEdge edge;
    edge.T_from_to = core::Exp(mapping::DrawError(wide, false, &rng));
    edge.information = RandomInformation(false, &rng);
    ExpectDerivatives<6>([&](auto& a, auto& b) { return mapping::LogMapTerms(edge, a, b); }, T_from, T_to);
    ExpectDerivatives<6>([&](auto& a, auto& b) { return mapping::G2oTerms(edge, a, b, false); }, T_from,
                         T_to);
    const auto weights = mapping::ChordalWeightsOf(edge, false);
    ExpectDerivatives<12>([&](auto& a, auto& b) { return mapping::ChordalTerms(edge, a, b, weights); },
                          T_from, T_to);
  }
}

TEST(ChordalStart, IsExactWithoutNoise) {
  for (const bool planar : {false, true}) {
    PoseGraph graph = NoisyRing(30, {0.0, 0.0}, planar, 1);
    const std::vector<Pose> truth = graph.T_map_node;
    for (size_t k = 1; k < truth.size(); ++k) graph.T_map_node[k] = Pose::Identity();
    const std::vector<Pose> start = mapping::ChordalStart(graph);
    for (size_t k = 0; k < truth.size(); ++k)
      EXPECT_LT((start[k].matrix() - truth[k].matrix()).norm(), 1e-9) << k;
  }
}

TEST(ChordalStart, HoldsFixedNodesWhereTheyAre) {
  PoseGraph graph = NoisyRing(30, {0.05, 0.02}, false, 2);
  graph.fixed = {3, 17};
  const std::vector<Pose> start = mapping::ChordalStart(graph);
  for (const uint32_t node : graph.fixed) EXPECT_EQ(start[node].matrix(), graph.T_map_node[node].matrix());
  EXPECT_GT((start[0].matrix() - graph.T_map_node[0].matrix()).norm(), 1e-3);
}

TEST(GraphSolver, EndsWhereNoNodeCanMoveToLowerTheCost) {
  for (const bool planar : {false, true}) {
    for (const CostConvention cost : kConventions) {
      PoseGraph graph = NoisyRing(25, {0.05, 0.03}, planar, 3);
      const Pose first = graph.T_map_node[0];
      const double before = mapping::CostOf(graph, cost);
      mapping::SolveOptions options{.cost = cost};
      options.function_tolerance = 1e-14;
      const SolveReport report = mapping::Optimise(&graph, options);
      EXPECT_TRUE(report.converged) << report.message;
      EXPECT_NEAR(report.initial_cost, before, 1e-9 * before);
      const double at = mapping::CostOf(graph, cost);
      EXPECT_NEAR(report.final_cost, at, 1e-9 * at);
      EXPECT_LT(at, 0.5 * before);
      EXPECT_EQ(graph.T_map_node[0].matrix(), first.matrix());
      for (uint32_t node = 1; node < graph.size(); ++node) {
        for (int k = 0; k < 6; ++k) {
          if (planar && k >= 2 && k <= 4) continue;
          constexpr double kStep = 1e-4;
          const double slope = (CostMoved(graph, cost, node, kStep * Vec6::Unit(k)) -
                                CostMoved(graph, cost, node, -kStep * Vec6::Unit(k))) /
                               (2 * kStep);
          EXPECT_LT(std::abs(slope), 1e-4 * at) << node << " " << k;
        }
        EXPECT_TRUE(!planar || graph.T_map_node[node].translation().z() == 0.0);
      }
    }
  }
}

TEST(GraphSolver, HoldsFixedNodesAndLeavesOutEdgesOfNoWeight) {
  PoseGraph graph = NoisyRing(20, {0.05, 0.03}, false, 4);
  graph.fixed = {5};
  const Pose held = graph.T_map_node[5];
  PoseGraph with_lie = graph;
  with_lie.edges.push_back(graph.edges[0]);
  with_lie.edges.back().T_from_to.translation().x() += 5.0;
  std::vector<double> weights(graph.edges.size(), 1.0);
  weights.push_back(0.0);
  mapping::Optimise(&graph);
  mapping::SolveOptions options;
  options.edge_weights = weights;
  mapping::Optimise(&with_lie, options);
  EXPECT_EQ(graph.T_map_node[5].matrix(), held.matrix());
  for (uint32_t k = 0; k < graph.size(); ++k)
    EXPECT_EQ(graph.T_map_node[k].matrix(), with_lie.T_map_node[k].matrix());
}

TEST(GraphSolver, IsTheSameEveryTime) {
  PoseGraph a = NoisyRing(60, {0.1, 0.05}, false, 6), b = a;
  mapping::Optimise(&a);
  mapping::Optimise(&b);
  for (uint32_t k = 0; k < a.size(); ++k) EXPECT_EQ(a.T_map_node[k].matrix(), b.T_map_node[k].matrix());
}

TEST(GraphSolver, AFailedSolveReturnsItsStart) {
  PoseGraph graph = NoisyRing(10, {0.1, 0.05}, false, 7);
  graph.edges[3].T_from_to.translation().x() = std::nan("");
  const std::vector<Pose> start = graph.T_map_node;
  const SolveReport report = mapping::Optimise(&graph);
  EXPECT_TRUE(report.failed);
  EXPECT_FALSE(report.converged);
  EXPECT_FALSE(report.message.empty());
  for (uint32_t k = 0; k < graph.size(); ++k) EXPECT_EQ(graph.T_map_node[k].matrix(), start[k].matrix());
}

TEST(GraphSolver, NodesThatNothingHoldsStayFinite) {
  PoseGraph graph = NoisyRing(10, {0.1, 0.05}, false, 8);
  graph.T_map_node.push_back(Pose::Identity());
  mapping::Optimise(&graph);
  for (const Pose& T : graph.T_map_node) EXPECT_TRUE(T.matrix().allFinite());
}

}  // namespace
}  // namespace atlas::tests
