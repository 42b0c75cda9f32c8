// What SLAM remembers, as a folder.
#include <gtest/gtest.h>

#include <cstring>

#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"
#include "mapping/atlas/saved_slam.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;
using core::Pose;
using core::Vec3;

NodeMemory NodeAtRandom(core::Rng* rng) {
  NodeMemory node;
  node.T_node_lidar = core::PoseFromXyzYaw({0.1, 0.0, 0.3}, 0.5);
  node.voxel_m = 0.2;
  for (int i = 0; i < 300; ++i) {
    const auto draw = [&] { return static_cast<float>(rng->Uniform(-5.0, 5.0)); };
    const float x = draw(), y = draw();
    node.points_lidar.emplace_back(x, y, draw());
  }
  for (size_t i = 0; i < RangeView::kCells; ++i) {
    node.nearest.push_back(static_cast<uint16_t>(rng->UniformInt(65536)));
    node.farthest.push_back(static_cast<uint16_t>(rng->UniformInt(65536)));
  }
  for (int16_t y = 3; y < 180; y = static_cast<int16_t>(y + 7)) {
    for (int16_t x = y % 5; x < PlaceDescriptor::kSide; x = static_cast<int16_t>(x + 11))
      node.plan.push_back({x, y});
  }
  return node;
}

struct SavedSlamTest : ::testing::Test {
  SavedSlamTest() {
    core::Rng rng(1);
    for (uint32_t node = 0; node < 3; ++node) {
      memory.graph.T_map_node.push_back(core::PoseFromXyzYaw({2.0 * node, 1.0, 0.0}, 0.3 * node));
      memory.nodes.push_back(NodeAtRandom(&rng));
    }
    for (uint32_t node = 1; node < 3; ++node)
      memory.graph.edges.push_back({node - 1, node, core::PoseFromXyzYaw({2.0, 0.0, 0.0}, 0.3)});
    memory.graph.edges.push_back(
        {0, 2, core::PoseFromXyzYaw({4.0, 0.1, 0.0}, 0.6), core::Mat6::Identity(), EdgeKind::kLoop});
    WriteSlamMemory(folder, memory);
  }
  ~SavedSlamTest() override { fs::remove_all(folder); }
  std::string Refusal() const {
    try {
      LoadSlamMemory(folder);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder = fs::path(::testing::TempDir()) / "saved_slam";
  SlamMemory memory;
};

TEST_F(SavedSlamTest, OpensAsItWas) {
  const SlamMemory opened = LoadSlamMemory(folder);
  ASSERT_EQ(opened.nodes.size(), memory.nodes.size());
  ASSERT_EQ(opened.graph.edges.size(), memory.graph.edges.size());
  EXPECT_EQ(opened.graph.edges[2].kind, EdgeKind::kLoop);
  for (size_t i = 0; i < memory.nodes.size(); ++i) {
    const NodeMemory &was = memory.nodes[i], &is = opened.nodes[i];
    EXPECT_TRUE(opened.graph.T_map_node[i].isApprox(memory.graph.T_map_node[i], 1e-12));
    EXPECT_TRUE(is.T_node_lidar.isApprox(was.T_node_lidar, 1e-9));
    EXPECT_EQ(is.voxel_m, was.voxel_m);
    EXPECT_EQ(is.points_lidar, was.points_lidar);
    EXPECT_EQ(is.nearest, was.nearest);
    EXPECT_EQ(is.farthest, was.farthest);
    ASSERT_EQ(is.plan.size(), was.plan.size());
    EXPECT_EQ(std::memcmp(is.plan.data(), was.plan.data(), was.plan.size() * sizeof(was.plan[0])), 0);
  }
}

TEST_F(SavedSlamTest, EveryMissingOrDamagedFileIsFoundOut) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  ASSERT_EQ(files.size(), 3u + 3 * 3);
  for (const fs::path& file : files) {
    const std::string whole = core::ReadFile(file);
    std::string damaged = whole;
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 1);
    core::WriteFileAtomically(file, damaged);
    EXPECT_NE(Refusal(), "") << file;
    fs::remove(file);
    EXPECT_NE(Refusal().find(file.filename().string()), std::string::npos) << file;
    core::WriteFileAtomically(file, whole);
  }
  EXPECT_EQ(Refusal(), "");
}

TEST_F(SavedSlamTest, AKeyframeTooManyIsFoundOut) {
  memory.nodes.push_back(memory.nodes.back());
  WriteSlamMemory(folder, memory);
  EXPECT_NE(Refusal().find("4 keyframes, 3 nodes"), std::string::npos) << Refusal();
}

}  // namespace
}  // namespace atlas::mapping
