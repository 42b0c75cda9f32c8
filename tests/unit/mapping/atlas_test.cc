// The atlas as it grows: which submap takes a revolution, and what a correction moves.
#include "mapping/atlas/atlas.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/rng.h"
#include "mapping/octree/queries.h"
#include "tests/support/room_sweep.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Pose;
using core::Vec3;
using core::Vec3f;

core::AnchoredSpin Anchored(const core::SpinEvent& spin, core::KeyframeId keyframe) {
  return {.spin = Shared(spin), .keyframe = keyframe};
}

/// The room of RoomSweep, seen again from where the odometry has moved by `shift` though the sensor has not.
core::SpinEvent Shifted(core::SpinEvent spin, const Vec3& shift) {
  core::PoseTrajectory moved;
  for (const core::StampedPose& pose : spin.T_odom_lidar.poses())
    moved.Add(pose.time_s, Eigen::Translation3d(shift) * pose.T);
  spin.T_odom_lidar = moved;
  return spin;
}

std::vector<core::KeyframeId> KeyframesOf(const Submap& submap) {
  std::vector<core::KeyframeId> ids;
  for (const HeldKeyframe& held : submap.keyframes) ids.push_back(held.sensor.keyframe);
  return ids;
}

struct AtlasTest : ::testing::Test {
  AtlasTest() { params.cloud_filter_m = 0.1; }
  Atlas Make() const { return {params, AtlasSetup{.resolution_m = 0.05, .integrator = {}, .map = {}}}; }
  AtlasParams params;
  PlacedSpins room = RoomSweep(4, 0.0, Vec3::Zero());
};

TEST_F(AtlasTest, KeyframesThatSeeTheSameRoomShareASubmap) {
  Atlas atlas = Make();
  const FixedPoses poses({Pose::Identity(), Pose::Identity(), Pose::Identity()});
  for (core::KeyframeId k = 0; k < 3; ++k) atlas.Integrate(Anchored(room.spins[k], k), poses);
  ASSERT_EQ(atlas.submaps().size(), 1u);
  EXPECT_EQ(KeyframesOf(*atlas.submaps()[0]), (std::vector<core::KeyframeId>{0, 1, 2}));
}

TEST_F(AtlasTest, AKeyframeThatSeesAnotherRoomBeginsASubmap) {
  Atlas atlas = Make();
  const FixedPoses poses({Pose::Identity(), Pose::Identity()});
  atlas.Integrate(Anchored(room.spins[0], 0), poses);
  atlas.Integrate(Anchored(Shifted(room.spins[1], Vec3(12.0, 0.0, 0.0)), 1), poses);
  ASSERT_EQ(atlas.submaps().size(), 2u);
  EXPECT_EQ(atlas.submaps()[1]->root, 1u);
}

TEST_F(AtlasTest, ASubmapEndsWhereItsWayIsLong) {
  params.lambda_odom_m = 1.0;
  params.cloud_overlap = 0.0;
  Atlas atlas = Make();
  std::vector<Pose> T_map_keyframe;
  for (int k = 0; k < 4; ++k) T_map_keyframe.push_back(core::PoseFromXyzYaw({0.4 * k, 0.0, 0.0}, 0.0));
  const FixedPoses poses(T_map_keyframe);
  for (core::KeyframeId k = 0; k < 4; ++k) atlas.Integrate(Anchored(room.spins[k], k), poses);
  ASSERT_EQ(atlas.submaps().size(), 2u);  // ways of 0, 0.4, 0.8 and 1.2 m
  EXPECT_EQ(atlas.submaps()[1]->root, 3u);
}

TEST_F(AtlasTest, ACorrectionMovesSubmapsAsWholesAndTouchesNoVoxel) {
  Atlas atlas = Make();
  const Pose moved = core::PoseFromXyzYaw({0.3, -0.2, 0.1}, 0.4);
  const FixedPoses before({Pose::Identity(), Pose::Identity()}), after({Pose::Identity(), moved});
  atlas.Integrate(Anchored(room.spins[0], 0), before);
  atlas.Integrate(Anchored(Shifted(room.spins[1], Vec3(12.0, 0.0, 0.0)), 1), before);
  const auto everything = TraceLimits{}.box_map;
  const std::vector<Vec3f> was = OccupiedCenters(*atlas.Snapshot(), everything);
  const auto held = atlas.Snapshot();
  atlas.Correct(after);
  const std::vector<Vec3f> is = OccupiedCenters(*atlas.Snapshot(), everything);
  ASSERT_EQ(is.size(), was.size());
  EXPECT_TRUE(OccupiedCenters(*held, everything) == was) << "a snapshot stays as it was";
  size_t stayed = 0, went = 0;
  for (size_t i = 0; i < is.size(); ++i) {
    const bool second = was[i].x() > 6.0f;
    const Vec3 expected = second ? Vec3(moved * was[i].cast<double>()) : Vec3(was[i].cast<double>());
    ASSERT_LT((is[i].cast<double>() - expected).norm(), 1e-5);
    ++(second ? went : stayed);
  }
  EXPECT_GT(std::min(stayed, went), 500u);
}

TEST_F(AtlasTest, ARevolutionEntersItsKeyframesSubmapOnceAndNoOther) {
  Atlas atlas = Make();
  const FixedPoses poses({Pose::Identity(), Pose::Identity()});
  const core::SpinEvent far = Shifted(room.spins[1], Vec3(12.0, 0.0, 0.0));
  atlas.Integrate(Anchored(room.spins[0], 0), poses);
  atlas.Integrate(Anchored(far, 1), poses);
  Atlas alone = Make();
  alone.Integrate(Anchored(far, 0), poses);
  const auto voxels = [](const Submap& submap) {
    std::vector<std::array<int, 5>> all;
    ForEachCell(submap.contents.Read()->tree, [&](const NodeKey& key, int level, int8_t value) {
      all.push_back({key.x, key.y, key.z, level, value});
    });
    return all;
  };
  EXPECT_TRUE(voxels(*atlas.submaps()[1]) == voxels(*alone.submaps()[0]));
  EXPECT_GT(voxels(*alone.submaps()[0]).size(), 1000u);
}

TEST_F(AtlasTest, WhatIsNewestIsRightWhereSubmapsOverlap) {
  params.cloud_overlap = 1.0;  // each keyframe its submap
  Atlas atlas = Make();
  const FixedPoses poses({Pose::Identity(), Pose::Identity()});
  const Vec3 shift(0.5, 0.0, 0.0);
  atlas.Integrate(Anchored(room.spins[0], 0), poses);
  // The level ray straight ahead met the wall x = 2 here, and goes on through it to the wall x = 2.5.
  const auto wall_near = [&](double x) {
    const Vec3 met(x, -0.2, 0.92);
    Vec3f nearest = Vec3f::Zero();
    for (const Vec3f& p : OccupiedCenters(*atlas.Snapshot(), TraceLimits{}.box_map)) {
      if ((p.cast<double>() - met).norm() < (nearest.cast<double>() - met).norm()) nearest = p;
    }
    EXPECT_LT((nearest.cast<double>() - met).norm(), 0.06);
    return Vec3(nearest.cast<double>());
  };
  const Vec3 old_wall = wall_near(2.0);
  atlas.Integrate(Anchored(Shifted(room.spins[1], shift), 1), poses);
  ASSERT_EQ(atlas.submaps().size(), 2u);
  EXPECT_EQ(atlas.Snapshot()->StateAt(old_wall), CellState::kFree);
  wall_near(2.5);
}

TEST(OverlapCloud, CountsPointsWithinTheDiagonalOfACell) {
  OverlapCloud cloud(0.1);
  const std::vector<Vec3f> kept = {{0.05f, 0.05f, 0.05f}, {1.05f, 0.0f, 0.0f}};
  cloud.Add(kept);
  const float d = 0.1f * std::sqrt(3.0f);
  const auto share = [&](const Vec3f& p) { return cloud.ShareNear(std::vector<Vec3f>{p}); };
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(share(kept[0] + 0.99f * d * Vec3f::Unit(axis)), 1.0) << axis;
    EXPECT_EQ(share(kept[0] - 0.99f * d * Vec3f::Unit(axis)), 1.0) << axis;
    EXPECT_EQ(share(kept[0] + 1.01f * d * Vec3f::Unit(axis)), 0.0) << axis;
  }
  EXPECT_EQ(cloud.ShareNear(std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {5, 0, 0}, {6, 0, 0}}), 0.5);
  EXPECT_EQ(cloud.ShareNear({}), 0.0);
}

TEST(OverlapCloud, FindsWhatAComparisonWithEachPointFinds) {
  constexpr float kFilterM = 0.1f;
  for (uint64_t seed = 0; seed < 6; ++seed) {
    core::Rng rng(seed);
    const auto drawn = [&](size_t n, double reach) {
      std::vector<Vec3f> points;
      for (size_t i = 0; i < n; ++i)
        points.emplace_back(static_cast<float>(rng.Uniform(-reach, reach)),
                            static_cast<float>(rng.Uniform(-reach, reach)),
                            static_cast<float>(rng.Uniform(-reach, reach)));
      return points;
    };
    OverlapCloud cloud(kFilterM);
    std::vector<Vec3f> kept;
    std::set<std::array<float, 3>> cells;
    for (int part = 0; part < 3; ++part) {
      const std::vector<Vec3f> points = drawn(700, 0.9);
      cloud.Add(points);
      for (const Vec3f& p : points) {
        const Vec3f cell = (p / kFilterM).array().floor();
        if (cells.insert({cell.x(), cell.y(), cell.z()}).second) kept.push_back(p);
      }
    }
    ASSERT_EQ(cloud.size(), kept.size());
    ASSERT_EQ(cloud.Points().size(), kept.size());
    const std::vector<Vec3f> asked = drawn(2000, 1.3);
    double near = 0.0;
    for (const Vec3f& p : asked)
      near += std::any_of(kept.begin(), kept.end(),
                          [&](const Vec3f& q) { return (q - p).squaredNorm() < 3.0f * kFilterM * kFilterM; });
    const double share = near / 2000.0;
    EXPECT_GT(share, 0.2);
    EXPECT_EQ(cloud.ShareNear(asked), share);
    EXPECT_EQ(cloud.ShareNear(asked, share - 1e-9), share);
    EXPECT_EQ(cloud.ShareNear(asked, share), 0.0);
  }
}

}  // namespace
}  // namespace atlas::tests
