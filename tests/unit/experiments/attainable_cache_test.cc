#include "experiments/judge/attainable_cache.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/files.h"
#include "tests/support/box_world.h"

namespace atlas::experiments {
namespace {

using tests::BoxWorld;
using tests::SmallWorld;
using tests::TestLidar;
using tests::TestRobot;

class AttainableCacheTest : public ::testing::Test {
 protected:
  AttainableCacheTest()
      : folder_(
            std::filesystem::temp_directory_path() /
            ("atlas_cache_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()))) {
    std::filesystem::remove_all(folder_);
    options_.lattice_m = 1.0;
  }
  ~AttainableCacheTest() override { std::filesystem::remove_all(folder_); }

  Attainable Load() const {
    return LoadOrComputeAttainable(world_.scene, truth_, TestRobot(), TestLidar(), options_, folder_,
                                   nullptr);
  }
  std::filesystem::path OnlyFile() const { return std::filesystem::directory_iterator(folder_)->path(); }

  BoxWorld world_ = SmallWorld();
  scenes::GroundTruth truth_ = world_.Truth(0.03);
  AttainableOptions options_;
  std::filesystem::path folder_;
};

TEST_F(AttainableCacheTest, ASecondLoadReadsTheSameSet) {
  const Attainable first = Load(), second = Load();
  EXPECT_FALSE(first.from_cache);
  EXPECT_TRUE(second.from_cache);
  EXPECT_EQ(first.attainable, second.attainable);
  EXPECT_EQ(first.coverage, second.coverage);
  EXPECT_EQ(first.positions, second.positions);
}

TEST_F(AttainableCacheTest, DamagedAndTruncatedFilesAreComputedAnew) {
  const Attainable first = Load();
  std::string content = core::ReadFile(OnlyFile());
  for (const size_t at : {size_t{3}, content.size() / 2, content.size() - 1}) {
    std::string damaged = content;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    core::WriteFileAtomically(OnlyFile(), damaged);
    const Attainable again = Load();
    EXPECT_FALSE(again.from_cache) << "byte " << at;
    EXPECT_EQ(again.attainable, first.attainable);
  }
  core::WriteFileAtomically(OnlyFile(), content.substr(0, content.size() - 5));
  EXPECT_FALSE(Load().from_cache);
  EXPECT_TRUE(Load().from_cache);
}

TEST_F(AttainableCacheTest, WhateverTheResultDependsOnChangesTheKey) {
  const auto key = [&] { return AttainableKey(world_.scene, truth_, TestRobot(), TestLidar(), options_); };
  const uint64_t original = key();
  options_.threads = 7;
  EXPECT_EQ(key(), original);
  options_.radius_m = 0.086;
  EXPECT_NE(key(), original);
  options_.radius_m = kObjectCoverageRadiusM;
  options_.sweep_roll_deg = 0.0;
  EXPECT_NE(key(), original);
  options_.sweep_roll_deg = 40.0;
  EXPECT_EQ(key(), original);
  for (double* option : {&options_.max_range_m, &options_.sweep_period_s, &options_.lattice_m,
                         &options_.target_spacing_m, &options_.min_rays, &options_.reach.cell_m}) {
    const double usual = std::exchange(*option, 1.5 * *option);
    EXPECT_NE(key(), original) << usual;
    *option = usual;
  }
  options_.headings = 4;
  EXPECT_NE(key(), original);
  options_.headings = 8;
  robots::RobotSpec mounted = TestRobot();
  mounted.T_base_lidar.translation().z() += 0.01;
  EXPECT_NE(AttainableKey(world_.scene, truth_, mounted, TestLidar(), options_), original);
  core::LidarModel far = TestLidar();
  far.max_range_m += 1.0;
  EXPECT_NE(AttainableKey(world_.scene, truth_, TestRobot(), far, options_), original);
  robots::RobotSpec narrow = TestRobot();
  narrow.half_width_m -= 0.05;
  EXPECT_NE(AttainableKey(world_.scene, truth_, narrow, TestLidar(), options_), original);
  truth_.two_sided.assign(truth_.points.size(), 1);
  EXPECT_NE(key(), original);
  world_.scene.parts[2].mesh.vertices[0].x() += 0.001f;
  EXPECT_NE(key(), original);
}

TEST_F(AttainableCacheTest, AFolderThatCannotBeWrittenIsNoError) {
  core::WriteFileAtomically(folder_ / "file", "x");
  folder_ /= "file";
  EXPECT_FALSE(Load().from_cache);
  EXPECT_FALSE(Load().from_cache);
  folder_ = folder_.parent_path();
}

}  // namespace
}  // namespace atlas::experiments
