// `atlas posegraph` as a user meets it.
#include <gtest/gtest.h>

#include "mapping/slam/false_loops.h"
#include "mapping/slam/g2o_file.h"
#include "mapping/slam/room_graph.h"
#include "tests/support/command_line.h"

namespace atlas::tests {
namespace {

class PoseGraphCommandLine : public CommandLine {
 protected:
  /// Writes the rooms as graph.g2o with ids 5, 6, ..., and where they truly are.
  void WriteRooms(double false_share) {
    mapping::RoomGraph rooms = mapping::MakeRoomGraph(300, 5, core::Rng(8));
    mapping::G2oGraph file;
    file.graph = rooms.AtTruth();
    for (uint32_t node = 0; node < 300; ++node) file.id.push_back(5 + node);
    mapping::WriteG2o(dir_ / "true.g2o", file);
    mapping::AddFalseLoops({.kind = mapping::FalseLoopKind::kRandom, .share = false_share}, core::Rng(1),
                           &file.graph);
    file.graph.T_map_node = rooms.graph.T_map_node;
    mapping::WriteG2o(dir_ / "graph.g2o", file);
  }
  /// The trajectory error that the command prints.
  double ErrorOf(const std::string& arguments) {
    const Outcome outcome = Atlas("posegraph " + arguments + " --truth true.g2o");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.text;
    const size_t at = outcome.text.find("alignment: ");
    EXPECT_NE(at, std::string::npos) << outcome.text;
    return at == std::string::npos ? 1e9 : std::stod(outcome.text.substr(at + 11));
  }
};

TEST_F(PoseGraphCommandLine, PrintsCostsInAllConventions) {
  WriteRooms(0.0);
  const Outcome outcome = Atlas("posegraph graph.g2o");
  EXPECT_EQ(outcome.exit_code, 0);
  for (const std::string word : {"log-map, with 1/2", "chordal isotropic, without 1/2", "chi2 of g2o",
                                 "initial", "final", "time", "edges rejected: 0", "300 nodes"})
    EXPECT_NE(outcome.text.find(word), std::string::npos) << word << "\n" << outcome.text;
}

TEST_F(PoseGraphCommandLine, WhatItWritesIsAtTheMinimum) {
  WriteRooms(0.0);
  const double error = ErrorOf("graph.g2o --out out.g2o");
  EXPECT_LT(error, 0.3);
  EXPECT_NEAR(ErrorOf("out.g2o"), error, 1e-4);
  EXPECT_EQ(mapping::ReadG2o(dir_ / "out.g2o").id.front(), 5);
}

TEST_F(PoseGraphCommandLine, RobustMethodsSurviveFalseLoops) {
  WriteRooms(0.0);
  const double clean = ErrorOf("graph.g2o");
  WriteRooms(0.3);
  EXPECT_GT(ErrorOf("graph.g2o"), 1.0);
  for (const std::string method : {"dcs", "gnc"})
    EXPECT_LE(ErrorOf("graph.g2o --out kept.g2o --robust " + method), 1.05 * clean + 0.01) << method;
  EXPECT_LT(mapping::ReadG2o(dir_ / "kept.g2o").graph.edges.size(),
            mapping::ReadG2o(dir_ / "graph.g2o").graph.edges.size());
}

TEST_F(PoseGraphCommandLine, BadFilesAreRefusedInOneLine) {
  Write("nan.g2o", "VERTEX_SE2 1 0 nan 0\n");
  ExpectRefusal("posegraph nan.g2o", {"nan.g2o:1: VERTEX_SE2", "nan is not finite"});
  Write("gap.g2o", "VERTEX_SE2 1 0 0 0\nVERTEX_SE2 2 0 0 0\nEDGE_SE2 1 3 0 0 0 1 0 0 1 0 1\n");
  ExpectRefusal("posegraph gap.g2o", {"gap.g2o:3", "node 3"});
  Write("two.g2o", "EDGE_SE2 1 2 0 0 0 1 0 0 1 0 1\nEDGE_SE2 3 4 0 0 0 1 0 0 1 0 1\n");
  ExpectRefusal("posegraph two.g2o", {"two.g2o", "2 pieces"});
  Write("empty.g2o", "");
  ExpectRefusal("posegraph empty.g2o", {"empty.g2o", "empty"});
  ExpectRefusal("posegraph none.g2o", {"none.g2o"});
  WriteRooms(0.0);
  Write("short.tum", "0 0 0 0 0 0 0 1\n");
  ExpectRefusal("posegraph graph.g2o --truth short.tum", {"short.tum", "1 poses", "300 nodes"});
  ExpectRefusal("posegraph graph.g2o --robust gmc", {"did you mean 'gnc'"});
}

}  // namespace
}  // namespace atlas::tests
