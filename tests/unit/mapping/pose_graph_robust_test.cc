#include <gtest/gtest.h>

#include <array>

#include "mapping/slam/false_loops.h"
#include "mapping/slam/pose_graph_slam.h"
#include "mapping/slam/room_graph.h"
#include "mapping/slam/trajectory_error.h"

namespace atlas::tests {
namespace {

using core::Pose;
using mapping::EdgeKind;
using mapping::FalseLoopKind;
using mapping::PoseEdge;
using mapping::PoseGraph;
using mapping::PoseGraphSlam;
using mapping::RobustReport;

constexpr std::array<FalseLoopKind, 4> kKinds = {FalseLoopKind::kRandom, FalseLoopKind::kLocal,
                                                 FalseLoopKind::kRandomGroup, FalseLoopKind::kLocalGroup};

/// The rooms with false loops, chained from odometry, and the number of the first false edge.
struct Deceived {
  mapping::RoomGraph rooms;
  PoseGraph graph;
  size_t first_false = 0;
};

Deceived Deceive(uint32_t nodes, FalseLoopKind kind, double share, bool planar = false) {
  Deceived d{mapping::MakeRoomGraph(nodes, 5, core::Rng(3), planar), {}, 0};
  d.graph = d.rooms.AtTruth();
  d.first_false = d.graph.edges.size();
  mapping::AddFalseLoops({.kind = kind, .share = share}, core::Rng(4), &d.graph);
  d.graph.T_map_node = d.rooms.graph.T_map_node;
  return d;
}

double CleanError(const mapping::RoomGraph& rooms) {
  PoseGraph clean = rooms.graph;
  mapping::Optimise(&clean);
  return mapping::AbsoluteTrajectoryError(clean.T_map_node, rooms.T_true);
}

TEST(FalseLoops, AreAsManyAndAsFalseAsAsked) {
  for (const FalseLoopKind kind : kKinds) {
    const Deceived d = Deceive(400, kind, 0.3);
    const auto count = static_cast<double>(d.graph.edges.size() - d.first_false);
    double true_loops = 0.0;
    for (size_t k = 0; k < d.first_false; ++k) true_loops += d.graph.edges[k].kind == EdgeKind::kLoop;
    EXPECT_NEAR(count / (count + true_loops), 0.3, 0.01);
    for (size_t k = d.first_false; k < d.graph.edges.size(); ++k) {
      const PoseEdge& edge = d.graph.edges[k];
      EXPECT_EQ(edge.kind, EdgeKind::kLoop);
      EXPECT_GT(mapping::SquaredError(edge, d.rooms.T_true[edge.from], d.rooms.T_true[edge.to]), 100.0);
      EXPECT_TRUE(kind != FalseLoopKind::kLocal || edge.to - edge.from <= 22u);
    }
  }
}

TEST(FalseLoops, OfAGroupAgreeWithEachOther) {
  const Deceived d = Deceive(400, FalseLoopKind::kRandomGroup, 0.3);
  const PoseEdge &a = d.graph.edges[d.first_false], &b = d.graph.edges[d.first_false + 9];
  EXPECT_EQ(b.from, a.from + 9);
  EXPECT_EQ(b.to, a.to + 9);
  const auto T = [&](uint32_t i, uint32_t j) { return d.rooms.T_true[i].inverse() * d.rooms.T_true[j]; };
  const Pose round = T(a.from, b.from) * b.T_from_to * T(b.to, a.to) * a.T_from_to.inverse();
  EXPECT_LT((round.matrix() - Pose::Identity().matrix()).norm(), 1e-9);
}

TEST(RobustGraph, FalseLoopsOfEachKindAreSurvived) {
  for (const FalseLoopKind kind : kKinds) {
    for (const double share : {0.1, 0.3, 0.5}) {
      const Deceived d = Deceive(300, kind, share);
      const double limit = 1.05 * CleanError(d.rooms) + 0.01;
      PoseGraph online = d.graph, full = d.graph, squared = d.graph;
      mapping::SolveWide(&online);
      const RobustReport report = mapping::SolveGnc(&full);
      EXPECT_LE(mapping::AbsoluteTrajectoryError(online.T_map_node, d.rooms.T_true), limit);
      EXPECT_LE(mapping::AbsoluteTrajectoryError(full.T_map_node, d.rooms.T_true), limit);
      size_t caught = 0;
      for (const size_t edge : report.rejected) caught += edge >= d.first_false;
      EXPECT_EQ(caught, d.graph.edges.size() - d.first_false);
      EXPECT_LE(report.rejected.size() - caught, 2u);
      mapping::Optimise(&squared);
      EXPECT_GT(mapping::AbsoluteTrajectoryError(squared.T_map_node, d.rooms.T_true), 2.0 * limit);
    }
  }
}

TEST(RobustGraph, FalseLoopsInThePlaneAreSurvived) {
  const Deceived d = Deceive(300, FalseLoopKind::kRandom, 0.3, true);
  PoseGraph full = d.graph;
  mapping::SolveGnc(&full);
  EXPECT_LE(mapping::AbsoluteTrajectoryError(full.T_map_node, d.rooms.T_true),
            1.05 * CleanError(d.rooms) + 0.01);
}

TEST(RobustGraph, WithoutFalseLoopsItIsLeastSquares) {
  const mapping::RoomGraph rooms = mapping::MakeRoomGraph(300, 5, core::Rng(9));
  PoseGraph squared = rooms.graph, full = rooms.graph;
  mapping::Optimise(&squared);
  const RobustReport report = mapping::SolveGnc(&full);
  ASSERT_TRUE(report.rejected.empty());
  for (uint32_t k = 0; k < full.size(); ++k)
    EXPECT_LT((full.T_map_node[k].matrix() - squared.T_map_node[k].matrix()).norm(), 1e-4);
}

TEST(RobustGraph, OdometryIsNeverRejected) {
  mapping::RoomGraph rooms = mapping::MakeRoomGraph(200, 5, core::Rng(9));
  rooms.graph.edges[50].T_from_to.translation().x() += 3.0;
  for (const size_t edge : mapping::SolveGnc(&rooms.graph).rejected)
    EXPECT_EQ(rooms.graph.edges[edge].kind, EdgeKind::kLoop);
}

/// Hands the measurements of `rooms` over: odometry, then all loops but the last `held_back`.
PoseGraphSlam Fed(const mapping::RoomGraph& rooms, size_t held_back, std::vector<PoseEdge>* later) {
  PoseGraphSlam slam(rooms.T_true.front());
  for (const PoseEdge& edge : rooms.graph.edges) {
    if (edge.kind == EdgeKind::kOdometry) slam.AddNode(edge.T_from_to, edge.information);
    if (edge.kind == EdgeKind::kLoop) later->push_back(edge);
  }
  const auto first_late = later->end() - static_cast<long>(held_back);
  for (auto it = later->begin(); it != first_late; ++it)
    slam.AddLoop(it->from, it->to, it->T_from_to, it->information);
  later->erase(later->begin(), first_late);
  return slam;
}

TEST(PoseGraphSlam, ChainsNodesAndSolvesWhenLoopsCome) {
  const mapping::RoomGraph rooms = mapping::MakeRoomGraph(300, 5, core::Rng(12));
  std::vector<PoseEdge> later;
  PoseGraphSlam slam = Fed(rooms, 0, &later);
  for (uint32_t k = 0; k < slam.graph().size(); ++k)
    EXPECT_LT((slam.T_map_node()[k].matrix() - rooms.graph.T_map_node[k].matrix()).norm(), 1e-9);
  EXPECT_EQ(slam.version(), 0u);
  EXPECT_FALSE(slam.Resolve().solve.failed);
  EXPECT_EQ(slam.version(), 1u);
  EXPECT_LE(mapping::AbsoluteTrajectoryError(slam.T_map_node(), rooms.T_true),
            1.05 * CleanError(rooms) + 0.01);
}

TEST(PoseGraphSlam, AFullPassIsTakenOverWhileTheRobotWentOn) {
  const mapping::RoomGraph rooms = mapping::MakeRoomGraph(300, 5, core::Rng(12));
  std::vector<PoseEdge> later;
  PoseGraphSlam slam = Fed(rooms, 2, &later);
  core::Mat6 information = core::Mat6::Identity() * 1e3;
  const size_t lie = slam.AddLoop(10, 200, Pose::Identity(), information);
  const mapping::FullPass pass = mapping::SolveFully(slam.graph());
  const Pose step = core::PoseFromXyzYaw({2, 0, 0}, 0.1);
  const uint32_t node = slam.AddNode(step, information);
  slam.AddLoop(later[0].from, later[0].to, later[0].T_from_to, later[0].information);
  slam.Adopt(pass);
  EXPECT_EQ(slam.rejected(), (std::vector<size_t>{lie}));
  EXPECT_EQ(slam.InlierGraph().edges.size() + 1, slam.graph().edges.size());
  EXPECT_EQ(slam.T_map_node()[node - 1].matrix(), pass.graph.T_map_node.back().matrix());
  const Pose T_step = slam.T_map_node()[node - 1].inverse() * slam.T_map_node()[node];
  EXPECT_LT((T_step.matrix() - step.matrix()).norm(), 1e-9);
  // The lie stays out of the next warm solve, which therefore is that without it.
  PoseGraph without = slam.InlierGraph();
  const RobustReport report = slam.Resolve();
  EXPECT_EQ(report.rejected, (std::vector<size_t>{lie}));
  mapping::SolveDcs(&without);
  for (uint32_t k = 0; k < without.size(); ++k)
    EXPECT_EQ(without.T_map_node[k].matrix(), slam.T_map_node()[k].matrix());
}

TEST(TrajectoryError, IsWhatIsLeftAfterTheBestRigidMotion) {
  const mapping::RoomGraph rooms = mapping::MakeRoomGraph(200, 5, core::Rng(12));
  const Pose T = core::Exp((core::Vec6() << 5, -7, 2, 0.3, 0.8, -1.1).finished());
  std::vector<Pose> moved = rooms.T_true;
  for (Pose& pose : moved) pose = T * pose;
  EXPECT_LT(mapping::AbsoluteTrajectoryError(moved, rooms.T_true), 1e-9);
  EXPECT_LT((mapping::AlignTrajectory(moved, rooms.T_true) * T).translation().norm(), 1e-9);
  // Off by 1 m up and down in turn, which no rigid motion mends.
  for (size_t k = 0; k < moved.size(); ++k)
    moved[k].translation() += T.linear() * core::Vec3(0, 0, k % 2 ? 1 : -1);
  EXPECT_NEAR(mapping::AbsoluteTrajectoryError(moved, rooms.T_true), 1.0, 0.01);
}

}  // namespace
}  // namespace atlas::tests
