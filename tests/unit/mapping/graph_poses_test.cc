// How sure the nodes of a graph are of each other, those behind the solved ones included.
#include "mapping/slam/graph_poses.h"

#include <gtest/gtest.h>

#include "mapping/slam/graph_solver.h"
#include "mapping/slam/room_graph.h"

namespace atlas::tests {
namespace {

using namespace mapping;

TEST(GraphPoses, NodesBehindTheSolvedOnesAreAsSureAsInTheWholeGraph) {
  PoseGraph whole = MakeRoomGraph(260, 7, core::Rng(3), false).graph;
  Optimise(&whole);
  constexpr uint32_t kSolved = 220;
  PoseGraph solved;
  std::vector<NodeStep> steps(whole.size());
  std::vector<PoseEdge> kept;
  for (const PoseEdge& edge : whole.edges) {
    const uint32_t last = std::max(edge.from, edge.to);
    if (edge.kind == EdgeKind::kOdometry) {
      steps[edge.to] = {edge.T_from_to, edge.information.inverse()};
    } else if (last >= kSolved) {
      continue;
    }
    kept.push_back(edge);
    if (last < kSolved) solved.edges.push_back(edge);
  }
  whole.edges = kept;
  solved.T_map_node.assign(whole.T_map_node.begin(), whole.T_map_node.begin() + kSolved);
  for (uint32_t node = kSolved; node < whole.size(); ++node)
    whole.T_map_node[node] = whole.T_map_node[node - 1] * steps[node].T_previous_node;

  const auto covariance = GraphCovariance::Of(whole);
  ASSERT_NE(covariance, nullptr);
  const auto graph = std::make_shared<const SolvedGraph>(std::make_shared<const PoseGraph>(solved));
  const GraphPoses poses(whole.T_map_node, 1, graph, steps);
  for (const auto& [a, b] :
       {std::pair{5u, 60u}, std::pair{60u, 5u}, std::pair{219u, 220u}, std::pair{3u, 259u},
        std::pair{259u, 3u}, std::pair{225u, 240u}, std::pair{240u, 225u}, std::pair{0u, 1u}}) {
    const auto sigma_m = poses.RelativeSigmaM(a, b);
    ASSERT_TRUE(sigma_m);
    const double expected = GreatestTranslationSigma(covariance->Relative(a, b));
    EXPECT_NEAR(*sigma_m, expected, 1e-6 * expected) << a << " " << b;
    EXPECT_GT(expected, 1e-4);
  }
  EXPECT_EQ(poses.RelativeSigmaM(7, 7), 0.0);
}

TEST(GraphPoses, TellsTheLoopsThatAreBelieved) {
  const PoseGraph graph = MakeRoomGraph(260, 7, core::Rng(3), false).graph;
  const SolvedGraph solved(std::make_shared<const PoseGraph>(graph));
  size_t loops = 0;
  for (const PoseEdge& edge : graph.edges) loops += edge.kind == EdgeKind::kLoop;
  EXPECT_EQ(solved.loops().size(), loops);
  EXPECT_GT(loops, 3u);
  for (const auto& [older, younger] : solved.loops()) EXPECT_LT(older, younger);
}

}  // namespace
}  // namespace atlas::tests
