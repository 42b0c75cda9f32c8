#include <gtest/gtest.h>
#include <octomap/octomap.h>

#include <filesystem>
#include <fstream>

#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"
#include "mapping/io/scan_graph.h"
#include "tests/support/shared_data.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;

/// Three scans of 0, 5 and 200 points with an edge, written by the OctoMap library.
std::string GraphByLibrary(octomap::ScanGraph* graph) {
  core::Rng rng(4);
  for (const int points : {0, 5, 200}) {
    auto* cloud = new octomap::Pointcloud();  // owned by the graph
    for (int i = 0; i < points; ++i) {
      cloud->push_back(static_cast<float>(rng.Normal()), static_cast<float>(rng.Normal()), 2.5f);
    }
    const double roll = rng.Uniform(-3, 3), pitch = rng.Uniform(-1.5, 1.5), yaw = rng.Uniform(-3, 3);
    graph->addNode(cloud, octomap::pose6d(1.0f, static_cast<float>(points), -2.0f, roll, pitch, yaw));
  }
  graph->connectPrevious();
  const fs::path path = fs::path(::testing::TempDir()) / "library.graph";
  EXPECT_TRUE(graph->writeBinary(path.string()));
  return core::ReadFile(path);
}

/// Points where the library takes them into the map frame.
void ExpectEqualsLibrary(std::string_view bytes, const octomap::ScanGraph& graph, double tolerance) {
  const ScanGraphIndex index = IndexScanGraph(bytes, "a.graph");
  ASSERT_EQ(index.nodes.size(), graph.size());
  size_t i = 0;
  for (const octomap::ScanNode* node : graph) {
    const RecordedCloud cloud = ReadScanOfGraph(bytes, index, i++, "a.graph");
    ASSERT_EQ(cloud.size(), node->scan->size());
    for (size_t k = 0; k < cloud.size(); ++k) {
      const octomap::point3d p = node->pose.transform((*node->scan)[static_cast<unsigned>(k)]);
      const core::Vec3 mine = cloud.T_map_lidar * cloud.p_lidar[k].cast<double>();
      ASSERT_LT((mine - core::Vec3(p.x(), p.y(), p.z())).norm(), tolerance);
    }
  }
}

TEST(ScanGraph, ReadsWhatTheOctomapLibraryWrites) {
  octomap::ScanGraph graph;
  const std::string bytes = GraphByLibrary(&graph);
  ExpectEqualsLibrary(bytes, graph, 1e-4);
  if (const auto path = tests::SharedData("octomap/spherical_scan.graph")) {
    octomap::ScanGraph real;
    ASSERT_TRUE(real.readBinary(path->string()));
    const std::string real_bytes = core::ReadFile(*path);
    ExpectEqualsLibrary(real_bytes, real, 1e-4);
    EXPECT_EQ(IndexScanGraph(real_bytes, "a").nodes[0].points, 10201u);
  }
}

TEST(ScanGraph, ReadsTextGraphsAsTheOctomapLibraryDoes) {
  const std::string text =
      "NODE 1 2 3 0.3 -0.4 2.5\n1 0 0\n0 2 0\n0.5 0.25 -1\nNODE 0 0 0 -1.2 0.7 -0.1\n3 2 1\n1e-1 -2 4\n";
  const fs::path path = fs::path(::testing::TempDir()) / "plain.log";
  core::WriteFileAtomically(path, text);
  octomap::ScanGraph graph;
  graph.readPlainASCII(path.string());
  ASSERT_EQ(graph.size(), 2u);
  ExpectEqualsLibrary(text, graph, 1e-5);
}

TEST(ScanGraph, RefusesEveryCutAndEveryWrongCount) {
  octomap::ScanGraph graph;
  const std::string bytes = GraphByLibrary(&graph);
  for (size_t cut = 0; cut < bytes.size(); cut += 7) {
    EXPECT_THROW(IndexScanGraph(std::string_view(bytes).substr(0, cut), "a"), core::InputError) << cut;
  }
  EXPECT_THROW(IndexScanGraph(bytes + "x", "a"), core::InputError);
  for (const size_t count : {0u, 4u}) {
    std::string wrong = bytes;
    wrong[count + 3] = '\x7f';
    EXPECT_THROW(IndexScanGraph(wrong, "a"), core::InputError) << count;
  }
  EXPECT_THROW(IndexScanGraph("NODE 0 0 0 0 0\n", "a"), core::InputError);
  EXPECT_THROW(IndexScanGraph("NODE 0 0 0 0 0 nan\n", "a"), core::InputError);
  EXPECT_THROW(IndexScanGraph("# nothing\n", "a"), core::InputError);
}

}  // namespace
}  // namespace atlas::mapping
