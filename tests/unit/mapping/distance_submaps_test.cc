// Submaps of signed distances: their states, and what fusion makes of them, voxel by voxel.
#include <gtest/gtest.h>

#include "mapping/atlas/distance_fusion.h"
#include "mapping/atlas/distance_states.h"
#include "mapping/atlas/submap_fusion.h"
#include "tests/support/random_octree.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;
using tests::FillAtRandom;
using tests::VoxelMap;

constexpr int kReach = 100;  ///< voxels: past what FillAtRandom fills

template <typename Visit>
void ForEachVoxel(const Visit& visit) {
  for (int z = -kReach; z < kReach; z += 3) {
    for (int y = -kReach; y < kReach; y += 3) {
      for (int x = -kReach; x < kReach; ++x) visit(NodeKey{x, y, z});
    }
  }
}

TEST(DistanceSubmaps, TheSignTellsTheStateWhereThereIsWeight) {
  TsdfOctree distances(0.05);
  VoxelMap<TsdfField> voxels;
  FillAtRandom(5, 64, &distances, &voxels);
  const OccupancyOctree states = StatesOf(distances);
  size_t known = 0;
  ForEachVoxel([&](const NodeKey& voxel) {
    const TsdfField::Value v = distances.At(voxel);
    const int8_t state = states.At(voxel);
    known += v.weight > 0;
    ASSERT_EQ(OccupancyField::Known(state), v.weight > 0);
    if (v.weight == 0) return;
    ASSERT_EQ(state > 0, v.distance <= 0);
    ASSERT_GT(std::abs(OccupancyField::LogOdds(state)), 1.9) << "as sure as it gets";
  });
  EXPECT_GT(known, 10000u);
}

TEST(DistanceSubmaps, FusionIsTheMeanByWeight) {
  OctreeContents a{OccupancyOctree(0.05), {}, TsdfOctree(0.05)}, b = a.Clone();
  VoxelMap<TsdfField> voxels;
  FillAtRandom(6, 40, &*a.distances, &voxels);
  FillAtRandom(7, 40, &*b.distances, &voxels);
  a.tree = StatesOf(*a.distances);
  b.tree = StatesOf(*b.distances);
  const TsdfOctree before = b.distances->Clone();
  FuseInto(a, Pose::Identity(), FusionRule::kAdd, &b);
  size_t both = 0;
  ForEachVoxel([&](const NodeKey& voxel) {
    const TsdfField::Value of_a = a.distances->At(voxel), of_b = before.At(voxel),
                           fused = b.distances->At(voxel);
    const int weight = of_a.weight + of_b.weight;
    ASSERT_EQ(fused.weight, std::min(weight, TsdfField::kMaxWeight));
    if (weight == 0) return;
    both += of_a.weight > 0 && of_b.weight > 0;
    ASSERT_NEAR(fused.distance, (of_a.weight * of_a.distance + of_b.weight * of_b.distance) / double(weight),
                0.51);
    ASSERT_EQ(b.tree.At(voxel) > 0, fused.distance <= 0) << "states follow";
  });
  EXPECT_GT(both, 1000u);
}

/// A plane through the origin, as distances along its normal.
TsdfOctree PlaneOf(const Vec3& normal, double resolution_m) {
  TsdfOctree tree(resolution_m);
  constexpr int kTruncation = 6, kHalf = 30;
  for (int z = -kHalf; z < kHalf; ++z) {
    for (int y = -kHalf; y < kHalf; ++y) {
      for (int x = -kHalf; x < kHalf; ++x) {
        const double d = normal.dot(tree.CenterOf({x, y, z}));
        if (std::abs(d) > kTruncation * resolution_m) continue;
        tree.Set({x, y, z}, {static_cast<int16_t>(std::lround(d / TsdfField::UnitM(resolution_m))), 3});
      }
    }
  }
  BlockMask all;
  all.bits.fill(~uint64_t{0});
  std::vector<NodeKey> keys;
  for (const auto* chunk : tree.Chunks()) keys.push_back(chunk->key);
  for (const NodeKey& key : keys) tree.Propagate(tree.Find(key), all);
  return tree;
}

TEST(DistanceSubmaps, APlaneStaysWhereItIsWhenItsSubmapIsTurned) {
  const Vec3 normal = Vec3(0.3, -0.5, 0.8).normalized();
  const Pose T_to_from =
      core::MakePose(core::RotationFromYawPitchRoll(0.5, 0.2, -0.1), Vec3(0.11, 0.07, -0.04));
  OctreeContents from{OccupancyOctree(0.05), {}, PlaneOf(normal, 0.05)},
      to{OccupancyOctree(0.05), {}, TsdfOctree(0.05)};
  from.tree = StatesOf(*from.distances);
  FuseInto(from, T_to_from, FusionRule::kAdd, &to);
  const Vec3 normal_to = T_to_from.linear() * normal;
  const double offset = normal_to.dot(T_to_from.translation());
  int near = 0;
  for (int z = -12; z < 12; ++z) {
    for (int y = -12; y < 12; ++y) {
      for (int x = -12; x < 12; ++x) {
        const double d = normal_to.dot(to.tree.CenterOf({x, y, z})) - offset;
        if (std::abs(d) > 0.15) continue;
        ++near;
        const TsdfField::Value held = to.distances->At(NodeKey{x, y, z});
        ASSERT_EQ(held.weight, 3);
        ASSERT_NEAR(held.distance * TsdfField::UnitM(0.05), d, 1e-4);
      }
    }
  }
  EXPECT_GT(near, 1000);
}

}  // namespace
}  // namespace atlas::mapping
