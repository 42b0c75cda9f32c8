// When submaps are taken up again and when two become one.
#include <gtest/gtest.h>

#include <algorithm>

#include "mapping/atlas/atlas.h"
#include "mapping/octree/queries.h"
#include "tests/support/moved_keyframes.h"
#include "tests/support/room_sweep.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::KeyframeId;
using core::Pose;
using core::Vec3;

/// A robot in the room of RoomSweep: odometry that jumps, a pose graph that a test corrects.
struct AtlasFusion : ::testing::Test {
  AtlasFusion() {
    params.cloud_overlap = 0.6;
    params.fusion_overlap_both = 0.3;
  }
  void Start() {
    atlas = std::make_unique<Atlas>(params, AtlasSetup{.resolution_m = 0.05, .integrator = {}, .map = {}});
  }
  /// The room once more, from keyframe `k`, which odometry takes to be `shift` away.
  void See(KeyframeId k, const Vec3& shift) {
    core::SpinEvent spin = room.spins[k % room.spins.size()];
    core::PoseTrajectory moved;
    for (const core::StampedPose& pose : spin.T_odom_lidar.poses())
      moved.Add(pose.time_s, Eigen::Translation3d(shift) * pose.T);
    spin.T_odom_lidar = moved;
    atlas->Integrate({.spin = Shared(spin), .keyframe = k}, Poses());
  }
  MovedKeyframes Poses() const {
    MovedKeyframes poses(T_map_keyframe, version);
    poses.sigma_m = sigma_m;
    poses.loops = loops;
    return poses;
  }
  /// Keyframes 2 and 3 of four lie where the room really is.
  void Correct() {
    for (const size_t k : {2u, 3u}) T_map_keyframe[k].translation() = -kFar;
    ++version;
    atlas->Correct(Poses());
  }
  /// Two keyframes in the room, two more that odometry takes to be far away.
  void TwoSubmaps() {
    Start();
    See(0, Vec3::Zero());
    See(1, Vec3::Zero());
    See(2, kFar);
    See(3, kFar);
    ASSERT_EQ(atlas->submaps().size(), 2u);
  }
  size_t count() const { return atlas->submaps().size(); }
  std::vector<KeyframeId> KeyframesOf(size_t submap) const {
    std::vector<KeyframeId> ids;
    for (const HeldKeyframe& held : atlas->submaps()[submap]->keyframes) ids.push_back(held.sensor.keyframe);
    return ids;
  }

  const Vec3 kFar = Vec3(12.0, 3.0, 0.0);
  AtlasParams params;
  std::unique_ptr<Atlas> atlas;
  std::vector<Pose> T_map_keyframe = std::vector<Pose>(8, Pose::Identity());
  uint64_t version = 0;
  std::optional<double> sigma_m = 0.05;
  std::vector<std::pair<KeyframeId, KeyframeId>> loops;
  PlacedSpins room = RoomSweep(8, 0.0, Vec3::Zero());
};

TEST_F(AtlasFusion, SubmapsOfOnePlaceBecomeOneWhenALoopBringsThemTogether) {
  TwoSubmaps();
  const size_t before = atlas->Bytes();
  Correct();
  ASSERT_EQ(count(), 1u);
  const Submap& survivor = *atlas->submaps()[0];
  EXPECT_EQ(survivor.id, 0u);
  EXPECT_EQ(survivor.root, 0u);
  EXPECT_EQ(KeyframesOf(0), (std::vector<KeyframeId>{0, 1, 2, 3}));
  EXPECT_EQ(survivor.clouds.size(), 2u);
  EXPECT_LT(atlas->Bytes(), 0.75 * static_cast<double>(before));
  // The way goes on in what is left, and numbers are not given twice.
  See(4, Vec3::Zero());
  EXPECT_EQ(KeyframesOf(0).back(), 4u);
  See(5, 2.0 * kFar);
  ASSERT_EQ(count(), 2u);
  EXPECT_EQ(atlas->submaps()[1]->id, 2u);
}

TEST_F(AtlasFusion, TheEvidenceOfBothIsInWhatIsLeft) {
  TwoSubmaps();
  Correct();
  Atlas alone(params, AtlasSetup{.resolution_m = 0.05, .integrator = {}, .map = {}});
  const MovedKeyframes poses(std::vector<Pose>(8, Pose::Identity()));
  for (KeyframeId k = 0; k < 4; ++k) alone.Integrate({.spin = Shared(room.spins[k]), .keyframe = k}, poses);
  const auto left = atlas->submaps()[0]->contents.Read(), like_it = alone.submaps()[0]->contents.Read();
  const OccupancyOctree &fused = left->tree, &expected = like_it->tree;
  size_t known = 0, like = 0;
  ForEachCell(expected, [&](const NodeKey& key, int level, int8_t value) {
    if (level != 0) return;
    ++known;
    like += fused.At(key) != 0 && (fused.At(key) > 0) == (value > 0);
  });
  EXPECT_GT(known, 5000u);
  EXPECT_GT(static_cast<double>(like), 0.97 * static_cast<double>(known));
}

TEST_F(AtlasFusion, WhatIsNotSureStaysApartUntilItIs) {
  sigma_m = 0.3;
  TwoSubmaps();
  Correct();
  EXPECT_EQ(count(), 2u);
  sigma_m = 0.1;  // the same poses, as far as the atlas can tell
  atlas->Correct(Poses());
  EXPECT_EQ(count(), 2u);
  ++version;  // a loop elsewhere: the two have not moved
  atlas->Correct(Poses());
  EXPECT_EQ(count(), 1u);
}

TEST_F(AtlasFusion, WhereNothingIsKnownOfUncertaintyNothingBecomesOne) {
  sigma_m.reset();
  TwoSubmaps();
  Correct();
  EXPECT_EQ(count(), 2u);
}

TEST_F(AtlasFusion, TheUncertaintyBoundCanBeTakenAway) {
  sigma_m.reset();
  params.sigma_max_m = 0.0;
  TwoSubmaps();
  Correct();
  EXPECT_EQ(count(), 1u);
}

TEST_F(AtlasFusion, FusionByOverlapCanBeSwitchedOff) {
  params.fusion_overlap = 0.0;
  TwoSubmaps();
  Correct();
  EXPECT_EQ(count(), 2u);
}

TEST_F(AtlasFusion, APairIsNotMeasuredAgainWhileItHardlyMoves) {
  TwoSubmaps();
  // Into the wall: they overlap by less than 0.7 of their volumes.
  for (const size_t k : {2u, 3u}) T_map_keyframe[k].translation() = -kFar + Vec3(2.5, 0.0, 0.0);
  ++version;
  atlas->Correct(Poses());
  ASSERT_EQ(count(), 2u);
  params.update_m = 5.0;
  const auto move_to_room = [&] { Correct(); };
  move_to_room();
  EXPECT_EQ(count(), 1u) << "moved past Eq. 4.5's thresholds";
}

TEST_F(AtlasFusion, UnderTheThresholdsOfPoseUpdateNothingIsMeasuredAgain) {
  params.update_m = 5.0;
  TwoSubmaps();
  for (const size_t k : {2u, 3u}) T_map_keyframe[k].translation() = -kFar + Vec3(2.5, 0.0, 0.0);
  ++version;
  atlas->Correct(Poses());
  ASSERT_EQ(count(), 2u);
  Correct();
  EXPECT_EQ(count(), 2u) << "2.5 m are less than 5";
  EXPECT_LT((atlas->submaps()[1]->T_map_submap.translation() + kFar).norm(), 1e-12) << "but it has moved";
}

TEST_F(AtlasFusion, TurnsPastTheThresholdAreMeasuredAgainToo) {
  for (const double threshold_deg : {2.5, 120.0}) {
    SCOPED_TRACE(threshold_deg);
    params.update_m = 5.0;
    params.update_deg = threshold_deg;
    T_map_keyframe.assign(8, Pose::Identity());
    TwoSubmaps();
    for (const size_t k : {2u, 3u})
      T_map_keyframe[k] = core::PoseFromXyzYaw(-kFar + Vec3(2.5, 0.0, 0.0), core::Radians(90.0));
    ++version;
    atlas->Correct(Poses());
    ASSERT_EQ(count(), 2u);
    for (const size_t k : {2u, 3u}) T_map_keyframe[k] = core::PoseFromXyzYaw(-kFar, 0.0);
    ++version;
    atlas->Correct(Poses());
    EXPECT_EQ(count(), threshold_deg < 90.0 ? 1u : 2u);
  }
}

TEST_F(AtlasFusion, AKeyframeGoesBackToTheSubmapThatItFits) {
  Start();
  See(0, Vec3::Zero());
  See(1, kFar);
  ASSERT_EQ(count(), 2u);
  See(2, Vec3::Zero());
  ASSERT_EQ(count(), 2u);
  EXPECT_EQ(KeyframesOf(0), (std::vector<KeyframeId>{0, 2}));
  See(3, kFar);
  EXPECT_EQ(KeyframesOf(1), (std::vector<KeyframeId>{1, 3}));
}

TEST_F(AtlasFusion, ButNotWhereItIsNotSureOfIt) {
  sigma_m = 0.3;
  Start();
  See(0, Vec3::Zero());
  See(1, kFar);
  See(2, Vec3::Zero());
  EXPECT_EQ(count(), 3u);
}

TEST_F(AtlasFusion, NorWhereReentryIsSwitchedOff) {
  params.reentry = false;
  params.fusion_overlap = 0.0;
  Start();
  See(0, Vec3::Zero());
  See(1, kFar);
  See(2, Vec3::Zero());
  EXPECT_EQ(count(), 3u);
}

TEST_F(AtlasFusion, WhatLiesOnAnotherLevelIsNeitherTakenUpNorFused) {
  // Tall enough a room that the second keyframe would fit the first's submap.
  for (const double level_m : {0.0, 0.2}) {
    params.level_m = level_m;
    T_map_keyframe[1].translation().z() = 0.3;
    Start();
    See(0, Vec3::Zero());
    See(1, Vec3(0.0, 0.0, -0.3));
    EXPECT_EQ(count(), level_m == 0.0 ? 1u : 2u);
    ++version;
    atlas->Correct(Poses());
    EXPECT_EQ(count(), level_m == 0.0 ? 1u : 2u);
  }
}

TEST_F(AtlasFusion, ALoopFusesWhatLiesAboutItsEnds) {
  params.fusion_overlap = 0.0;
  params.reentry = false;
  params.cloud_overlap = 1.0;  // a keyframe each
  for (size_t k = 0; k < T_map_keyframe.size(); ++k)
    T_map_keyframe[k].translation().x() = static_cast<double>(k);
  const auto run = [&](double cluster_m) {
    params.lambda_cluster_m = cluster_m;
    loops.clear();
    version = 0;
    Start();
    for (KeyframeId k = 0; k < 8; ++k) See(k, Vec3::Zero());
    EXPECT_EQ(count(), 8u);
    loops = {{1, 6}};
    ++version;
    atlas->Correct(Poses());
    return count();
  };
  EXPECT_EQ(run(0.0), 8u);
  EXPECT_EQ(run(0.5), 7u);  // 1 and 6
  EXPECT_EQ(KeyframesOf(1), (std::vector<KeyframeId>{1, 6}));
  EXPECT_EQ(run(1.5), 3u);  // 0, 1, 2 and 5, 6, 7
  EXPECT_EQ(KeyframesOf(0), (std::vector<KeyframeId>{0, 1, 2, 5, 6, 7}));
}

}  // namespace
}  // namespace atlas::tests
