// Octrees that come and go: what is read back is what was there, and a memory limit changes no answer.
#include "mapping/atlas/paged_contents.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <thread>

#include "core/files.h"
#include "mapping/atlas/atlas.h"
#include "tests/support/moved_keyframes.h"
#include "tests/support/room_sweep.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::KeyframeId;
using core::Pose;
using core::Vec3;
namespace fs = std::filesystem;

OctreeContents OneVoxel(int x, int8_t value) {
  OctreeContents contents{OccupancyOctree(0.05), {}};
  contents.tree.Set({x, 0, 0}, value);
  return contents;
}

TEST(PagedContents, WhatWasUsedLongestAgoGoesToDiskAndComesBack) {
  const size_t one = OneVoxel(0, 5).tree.Bytes();
  const auto pager = std::make_shared<ContentsPager>(2 * one + one / 2);
  std::vector<PagedContents> all;
  for (int i = 0; i < 4; ++i) all.emplace_back(pager, OneVoxel(i, static_cast<int8_t>(10 + i)));
  pager->Trim();
  EXPECT_LE(pager->counts().resident_bytes, 2 * one + one / 2);
  EXPECT_EQ(all[0].ResidentBytes(), 0u);
  EXPECT_EQ(all[1].ResidentBytes(), 0u);
  EXPECT_GT(all[3].ResidentBytes(), 0u);
  for (int i = 0; i < 4; ++i)
    EXPECT_EQ(all[static_cast<size_t>(i)].Read()->tree.At(NodeKey{i, 0, 0}), 10 + i);
  EXPECT_GE(pager->counts().read, 2u);
}

TEST(PagedContents, WhatIsWrittenAfterItCameBackIsWhatStaysNextTime) {
  const auto pager = std::make_shared<ContentsPager>(1);
  PagedContents contents(pager, OneVoxel(0, 5));
  for (int i = 1; i < 5; ++i) {
    pager->Trim();
    EXPECT_EQ(contents.ResidentBytes(), 0u);
    contents.Write()->tree.Set({i, 0, 0}, static_cast<int8_t>(5 + i));
  }
  pager->Trim();
  const auto held = contents.Read();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(held->tree.At(NodeKey{i, 0, 0}), 5 + i);
}

TEST(PagedContents, WhatIsSharedStaysAsItWas) {
  const auto pager = std::make_shared<ContentsPager>(1);
  PagedContents contents(pager, OneVoxel(0, 5));
  pager->Trim();
  const auto shared = contents.Share();
  contents.Write()->tree.Set({0, 0, 0}, 40);
  pager->Trim();
  EXPECT_EQ(shared->Get()->tree.At(NodeKey{0, 0, 0}), 5);
  EXPECT_EQ(contents.Read()->tree.At(NodeKey{0, 0, 0}), 40);
}

TEST(PagedContents, HowManyThreadsAskAtOnceDoesNotMatter) {
  const auto pager = std::make_shared<ContentsPager>(1);
  std::vector<PagedContents> all;
  for (int i = 0; i < 6; ++i) all.emplace_back(pager, OneVoxel(i, static_cast<int8_t>(10 + i)));
  std::vector<std::thread> threads;
  std::atomic<int> wrong = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int k = 0; k < 50; ++k) {
        const int i = (k * (t + 1)) % 6;
        wrong += all[static_cast<size_t>(i)].Read()->tree.At(NodeKey{i, 0, 0}) != 10 + i;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

/// Rooms in a row, each seen twice and left again.
struct PagedAtlas : ::testing::Test {
  std::unique_ptr<Atlas> Walked(double limit_mb) const {
    AtlasParams params;
    params.memory_limit_mb = limit_mb;
    auto atlas = std::make_unique<Atlas>(
        params, AtlasSetup{.resolution_m = 0.05, .integrator = {}, .map = {.behind_surface = true}});
    MovedKeyframes poses(std::vector<Pose>(12, Pose::Identity()));
    poses.sigma_m = 0.01;
    const PlacedSpins room = RoomSweep(12, 0.0, Vec3::Zero());
    for (KeyframeId k = 0; k < 12; ++k) {
      core::SpinEvent spin = room.spins[k];
      core::PoseTrajectory moved;
      for (const core::StampedPose& pose : spin.T_odom_lidar.poses())
        moved.Add(pose.time_s, Eigen::Translation3d(8.0 * (k % 6), 0.0, 0.0) * pose.T);
      spin.T_odom_lidar = moved;
      atlas->Integrate({.spin = Shared(spin), .keyframe = k}, poses);
    }
    return atlas;
  }
};

TEST_F(PagedAtlas, AQuarterOfTheMemoryGivesTheSameMapByteForByte) {
  const auto whole = Walked(0.0);
  ASSERT_EQ(whole->submaps().size(), 6u);
  const double need_mb = 1e-6 * static_cast<double>(whole->pager().counts().resident_bytes);
  const auto paged = Walked(0.25 * need_mb);
  EXPECT_GT(paged->pager().counts().read, 3u);
  EXPECT_LT(1e-6 * static_cast<double>(paged->pager().counts().resident_bytes), 0.3 * need_mb);

  const auto view = whole->Snapshot(), other = paged->Snapshot();
  EXPECT_TRUE(OccupiedCenters(*view, TraceLimits{}.box_map) ==
              OccupiedCenters(*other, TraceLimits{}.box_map));
  core::Rng rng(3);
  std::vector<RaySample> a, b;
  for (int i = 0; i < 400; ++i) {
    const Vec3 origin(rng.Uniform(-1.0, 42.0), rng.Uniform(-1.5, 1.5), rng.Uniform(0.2, 2.0));
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), 0.3 * rng.Normal()).normalized();
    EXPECT_EQ(view->StateAt(origin), other->StateAt(origin));
    ASSERT_EQ(view->Trace(origin, direction, {}, &a), other->Trace(origin, direction, {}, &b));
    ASSERT_EQ(a.size(), b.size());
    for (size_t k = 0; k < a.size(); ++k) {
      ASSERT_EQ(a[k].occupancy, b[k].occupancy);
      ASSERT_EQ(a[k].length_m, b[k].length_m);
      ASSERT_EQ(a[k].behind_surface, b[k].behind_surface);
    }
  }

  const fs::path folder = fs::path(::testing::TempDir()) / "paged_atlas";
  fs::remove_all(folder);
  WriteAtlas(folder / "a", whole->Saved());
  WriteAtlas(folder / "b", paged->Saved());
  size_t files = 0;
  for (const auto& file : fs::directory_iterator(folder / "a")) {
    ++files;
    EXPECT_TRUE(core::ReadFile(file.path()) == core::ReadFile(folder / "b" / file.path().filename()))
        << file.path();
  }
  EXPECT_GT(files, 15u);
  fs::remove_all(folder);
}

TEST_F(PagedAtlas, AViewOutlivesItsAtlas) {
  auto atlas = Walked(0.1);
  const auto view = atlas->Snapshot();
  atlas.reset();
  EXPECT_GT(OccupiedCenters(*view, TraceLimits{}.box_map).size(), 5000u);
}

}  // namespace
}  // namespace atlas::tests
