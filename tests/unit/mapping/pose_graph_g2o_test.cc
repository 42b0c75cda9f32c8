#include <gtest/gtest.h>

#include "core/errors.h"
#include "mapping/slam/g2o_file.h"

namespace atlas::tests {
namespace {

using mapping::EdgeKind;
using mapping::G2oGraph;
using mapping::ParseG2o;

const std::string kPlane =
    "VERTEX_SE2 30 1 2 0.5\n"
    "VERTEX_SE2 10 0 0 0\n"
    "VERTEX_SE2 11 1 0 0\n"
    "VERTEX_XY 5 1 1\n"
    "FIX 10\n"
    "EDGE_SE2 10 11 1 0 0.1 4 1 0 5 0 9 # measured\n"
    "EDGE_SE2 11 30 0 2 0.5 1 0 0 1 0 1\r\n"
    "EDGE_SE2 30 10 0 2 0.5 1 0 0 1 0 1\n";

const std::string kSpace =
    "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\n"
    "VERTEX_SE3:QUAT 1 1 2 3 0 0 0.70710678 0.70710678\n"
    "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0.70710678 -0.70710678 "
    "1 0.1 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0.2 6\n";

std::string ErrorIn(const std::string& text) {
  try {
    ParseG2o(text, "a.g2o");
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "";
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

void ExpectError(const std::string& text, const std::vector<std::string>& words) {
  const std::string error = ErrorIn(text);
  EXPECT_EQ(error.find('\n'), std::string::npos);
  for (const std::string& word : words)
    EXPECT_NE(error.find(word), std::string::npos) << "'" << error << "' lacks '" << word << "'";
}

TEST(G2oFile, NodesAreInTheOrderOfTheirIds) {
  const G2oGraph file = ParseG2o(kPlane, "a.g2o");
  EXPECT_TRUE(file.graph.planar && file.has_poses);
  EXPECT_EQ(file.id, (std::vector<int64_t>{10, 11, 30}));
  EXPECT_EQ(file.graph.fixed, (std::vector<uint32_t>{0}));
  EXPECT_EQ(file.skipped, 1u);
  EXPECT_EQ(file.first_skipped, "VERTEX_XY");
  EXPECT_NEAR(core::YawOf(file.graph.T_map_node[2].linear()), 0.5, 1e-12);
  EXPECT_EQ(file.graph.T_map_node[2].translation(), core::Vec3(1, 2, 0));
  ASSERT_EQ(file.graph.edges.size(), 3u);
  const auto& W = file.graph.edges[0].information;
  EXPECT_EQ(W(0, 0), 4.0);
  EXPECT_EQ(W(0, 1), 1.0);
  EXPECT_EQ(W(1, 0), 1.0);
  EXPECT_EQ(W(1, 1), 5.0);
  EXPECT_EQ(W(5, 5), 9.0);
}

TEST(G2oFile, LoopsAreEdgesThatJoinWhatOdometryAlreadyJoins) {
  const G2oGraph file = ParseG2o(kPlane, "a.g2o");
  EXPECT_EQ(file.graph.edges[0].kind, EdgeKind::kOdometry);  // 10 to 11
  EXPECT_EQ(file.graph.edges[1].kind, EdgeKind::kOdometry);  // 11 to 30: nothing else holds 30
  EXPECT_EQ(file.graph.edges[2].kind, EdgeKind::kLoop);
}

TEST(G2oFile, SpaceHasTranslationFirstAndEitherSignOfTheQuaternion) {
  const G2oGraph file = ParseG2o(kSpace, "a.g2o");
  ASSERT_EQ(file.graph.edges.size(), 1u);
  const auto& edge = file.graph.edges[0];
  EXPECT_LT((edge.T_from_to * core::Vec3(1, 0, 0) - core::Vec3(1, 1, 3)).norm(), 1e-7);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(edge.information(k, k), k + 1.0);
  EXPECT_EQ(edge.information(1, 0), 0.1);
  EXPECT_EQ(edge.information(5, 4), 0.2);
}

TEST(G2oFile, WhatIsWrittenReadsBackTheSame) {
  for (const std::string& text : {kPlane, kSpace}) {
    const G2oGraph file = ParseG2o(text, "a.g2o");
    const std::string written = FormatG2o(file);
    const G2oGraph again = ParseG2o(written, "b.g2o");
    ASSERT_EQ(again.id, file.id);
    EXPECT_EQ(again.graph.fixed, file.graph.fixed);
    for (uint32_t k = 0; k < file.graph.size(); ++k) {
      EXPECT_LT((again.graph.T_map_node[k].matrix() - file.graph.T_map_node[k].matrix()).norm(), 1e-15);
    }
    for (size_t k = 0; k < file.graph.edges.size(); ++k) {
      EXPECT_EQ(again.graph.edges[k].information, file.graph.edges[k].information);
      EXPECT_LT((again.graph.edges[k].T_from_to.matrix() - file.graph.edges[k].T_from_to.matrix()).norm(),
                1e-15);
    }
  }
}

TEST(G2oFile, WithoutVerticesPosesComeFromTheEdges) {
  const G2oGraph file =
      ParseG2o("EDGE_SE2 7 8 1 0 1.5 1 0 0 1 0 1\nEDGE_SE2 8 9 1 0 0 1 0 0 1 0 1\n", "a.g2o");
  EXPECT_FALSE(file.has_poses);
  EXPECT_EQ(file.id, (std::vector<int64_t>{7, 8, 9}));
  EXPECT_LT((file.graph.T_map_node[2].translation() - core::Vec3(1 + std::cos(1.5), std::sin(1.5), 0)).norm(),
            1e-9);
}

TEST(G2oFile, BadNumbersAreNamedWithTheirLine) {
  ExpectError(Replaced(kPlane, "1 2 0.5", "1 nan 0.5"), {"a.g2o:1: VERTEX_SE2", "nan is not finite"});
  ExpectError(Replaced(kPlane, "1 2 0.5", "1 x 0.5"), {"a.g2o:1", "'x' is no number"});
  ExpectError(Replaced(kPlane, "1 2 0.5", "1 0.5"), {"a.g2o:1", "3 numbers (4)"});
  ExpectError(Replaced(kPlane, "1 2 0.5", "1 1e300 0.5"), {"a.g2o:1", "limit 1e+07"});
  ExpectError(Replaced(kPlane, "VERTEX_SE2 30", "VERTEX_SE2 3.5"), {"a.g2o:1", "'3.5' is no integer"});
  ExpectError(Replaced(kPlane, "9 # measured", "9 9"), {"a.g2o:6: EDGE_SE2", "12 numbers (11 or 14)"});
  ExpectError(Replaced(kPlane, "4 1 0 5 0 9", "4 1 0 5 0 inf"), {"a.g2o:6", "inf is not finite"});
}

TEST(G2oFile, QuaternionsHaveLengthOne) {
  ExpectError(Replaced(kSpace, "0 0 0 0 0 0 0 1", "0 0 0 0 0 0 0 0"),
              {"a.g2o:1", "length of the quaternion"});
  ExpectError(Replaced(kSpace, "-0.70710678", "-0.8"), {"a.g2o:3", "length of the quaternion", "1.06"});
}

TEST(G2oFile, InformationIsSymmetricAndPositiveDefinite) {
  ExpectError(Replaced(kPlane, "4 1 0 5 0 9", "4 1 0 -5 0 9"), {"a.g2o:6", "not positive definite", "-5"});
  ExpectError(Replaced(kPlane, "4 1 0 5 0 9", "4 7 0 5 0 9"), {"a.g2o:6", "not positive definite"});
  ExpectError(Replaced(kPlane, "4 1 0 5 0 9", "4 1 0 5 0 0"), {"a.g2o:6", "not positive definite"});
  ExpectError(Replaced(kPlane, "4 1 0 5 0 9", "4 1 0 2 5 0 0 0 9"), {"a.g2o:6", "not symmetric"});
  EXPECT_EQ(ErrorIn(Replaced(kPlane, "4 1 0 5 0 9", "4 1 0 1 5 0 0 0 9")), "");
  ExpectError(Replaced(kSpace, "1 0.1 0", "1 2 0"), {"a.g2o:3", "not positive definite"});
}

TEST(G2oFile, CrossTermsThatMakeInformationIndefiniteAreDroppedAndCounted) {
  const G2oGraph file = ParseG2o(Replaced(kSpace, "1 0.1 0 0 0 0", "1 0.1 0 50 0 0"), "a.g2o");
  EXPECT_EQ(file.without_cross_terms, 1u);
  EXPECT_EQ(file.graph.edges[0].information(0, 3), 0.0);
  EXPECT_EQ(file.graph.edges[0].information(0, 1), 0.1);
  EXPECT_EQ(ParseG2o(kSpace, "a.g2o").without_cross_terms, 0u);
}

TEST(G2oFile, NodesAreThereOnceAndConnected) {
  ExpectError(Replaced(kPlane, "EDGE_SE2 11 30", "EDGE_SE2 11 31"), {"a.g2o:7", "node 31 has no vertex"});
  ExpectError(Replaced(kPlane, "FIX 10", "FIX 12"), {"a.g2o:5: FIX", "node 12"});
  ExpectError(Replaced(kPlane, "VERTEX_SE2 11", "VERTEX_SE2 10"), {"a.g2o:3", "id 10 is there twice"});
  ExpectError(Replaced(kPlane, "EDGE_SE2 10 11", "EDGE_SE2 10 10"), {"a.g2o:6", "node 10 to itself"});
  ExpectError(kPlane + "VERTEX_SE2 77 0 0 0\n", {"a.g2o", "2 pieces", "node 77"});
  ExpectError(kPlane + kSpace, {"a.g2o:9", "SE2 and SE3"});
}

TEST(G2oFile, EmptyGraphsAreRefused) {
  ExpectError("", {"a.g2o", "empty"});
  ExpectError("VERTEX_SE2 1 0 0 0\n", {"a.g2o", "no edges"});
  ExpectError("hello world\nx\n", {"a.g2o", "2 lines skipped", "'hello'"});
}

}  // namespace
}  // namespace atlas::tests
