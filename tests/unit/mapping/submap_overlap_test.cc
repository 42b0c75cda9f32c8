// Algorithm 2 of the thesis against tables of voxels.
#include "mapping/atlas/submap_overlap.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "core/rng.h"
#include "mapping/atlas/block_window.h"
#include "mapping/octree/queries.h"
#include "tests/support/random_octree.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Pose;
using core::Vec3;

constexpr double kVoxelM = 0.1;

/// Voxel to log-odds.
using VoxelTable = std::map<std::array<int, 3>, int8_t>;

VoxelTable RandomVoxels(core::Rng* rng, int count, int reach) {
  VoxelTable table;
  for (int i = 0; i < count; ++i) {
    const auto at = [&] { return static_cast<int>(std::floor(rng->Uniform(-reach, reach))); };
    table[{at(), at(), at()}] = rng->Uniform(0.0, 1.0) < 0.3 ? 40 : -20;
  }
  return table;
}

OccupancyOctree TreeOfVoxels(const VoxelTable& table) {
  OccupancyOctree tree(kVoxelM);
  for (const auto& [voxel, value] : table) tree.Set({voxel[0], voxel[1], voxel[2]}, value);
  return tree;
}

/// Every voxel of `read`, looked up in `ref`.
SubmapOverlap ByTables(const VoxelTable& read, const VoxelTable& ref, const Pose& T_ref_read) {
  double same = 0.0;
  for (const auto& [voxel, value] : read) {
    const Vec3 p =
        T_ref_read * (kVoxelM * (Vec3(voxel[0], voxel[1], voxel[2]).array() + 0.5)).matrix() / kVoxelM;
    const auto found = ref.find({static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                                 static_cast<int>(std::floor(p.z()))});
    if (found != ref.end() && (found->second > 0) == (value > 0)) ++same;
  }
  return {same / static_cast<double>(read.size()), same / static_cast<double>(ref.size())};
}

TEST(SubmapOverlap, CountsVoxelsThatBothKnowAsTheSame) {
  for (uint64_t seed = 0; seed < 6; ++seed) {
    core::Rng rng(seed);
    const VoxelTable read = RandomVoxels(&rng, 3000, 9), ref = RandomVoxels(&rng, 6000, 11);
    const Pose T = core::MakePose(core::RotationFromYawPitchRoll(rng.Uniform(-3.0, 3.0), 0.1, -0.2),
                                  Vec3(rng.Uniform(-0.3, 0.3), 0.12, -0.07));
    const OccupancyOctree tree = TreeOfVoxels(read), other = TreeOfVoxels(ref);
    ASSERT_EQ(KnownVoxels(tree), read.size());
    const SubmapOverlap found = OverlapOf(tree, read.size(), other, ref.size(), T),
                        expected = ByTables(read, ref, T);
    EXPECT_NEAR(found.of_read, expected.of_read, 1e-12);
    EXPECT_NEAR(found.of_ref, expected.of_ref, 1e-12);
    EXPECT_GT(expected.of_read, 0.1);
  }
}

TEST(SubmapOverlap, CountsVolumeWhateverItIsStoredIn) {
  // Two blocks of free space, one uniform, one voxel by voxel, and a coarse cell that is occupied.
  OccupancyOctree tree(kVoxelM);
  auto* chunk = tree.FindOrCreate({0, 0, 0});
  tree.MakeUniform(chunk, BlockIndex(0, 0, 0), -20, 0);
  for (int i = 0; i < kBlockVoxels; ++i) tree.Set({8 + (i & 7), i >> 3 & 7, i >> 6}, -20);
  tree.MakeCoarse(chunk, BlockIndex(2, 0, 0), 0).Set(5, 40);
  EXPECT_EQ(KnownVoxels(tree), 512u + 512u + 8u);
  // Half of the uniform block is known to the other.
  OccupancyOctree half(kVoxelM);
  for (int i = 0; i < kBlockVoxels; ++i) {
    if ((i & 7) < 4) half.Set({i & 7, i >> 3 & 7, i >> 6}, -8);
  }
  const SubmapOverlap overlap = OverlapOf(tree, 1032, half, 256, Pose::Identity());
  EXPECT_DOUBLE_EQ(overlap.of_read, 256.0 / 1032.0);
  EXPECT_DOUBLE_EQ(overlap.of_ref, 1.0);
}

/// Algorithm 2, a look at the tree for each centre.
SubmapOverlap OneByOne(const OccupancyOctree& read, const OccupancyOctree& ref, const Pose& T_ref_read) {
  double same = 0.0;
  ForEachCell(read, [&](const NodeKey& key, int level, int8_t value) {
    const int parts = level == kBlockLevel ? 2 : 1, side = (1 << level) / parts;
    for (int i = 0; i < parts * parts * parts; ++i) {
      const Vec3 at(parts * key.x + (i & 1), parts * key.y + (i >> 1 & 1), parts * key.z + (i >> 2));
      const int8_t other = ref.At(T_ref_read * (kVoxelM * side * (at.array() + 0.5)).matrix());
      if (OccupancyField::Known(other) && (other > 0) == (value > 0)) same += std::pow(side, 3);
    }
  });
  return {same / static_cast<double>(KnownVoxels(read)), same / static_cast<double>(KnownVoxels(ref))};
}

TEST(SubmapOverlap, BlockByBlockIsAsVoxelByVoxel) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    OccupancyOctree read(kVoxelM), ref(kVoxelM);
    VoxelMap<OccupancyField> unused;
    FillAtRandom<OccupancyField>(seed, 60, &read, &unused);
    FillAtRandom<OccupancyField>(100 + seed, 60, &ref, &unused);
    core::Rng rng(seed);
    const auto turn = [&](double most) { return seed == 0 ? 0.0 : rng.Uniform(-most, most); };
    const Pose T = core::MakePose(core::RotationFromYawPitchRoll(turn(3.0), turn(0.3), turn(0.3)),
                                  Vec3(turn(4.0), turn(4.0), turn(2.0)));
    const SubmapOverlap found = OverlapOf(read, KnownVoxels(read), ref, KnownVoxels(ref), T),
                        expected = OneByOne(read, ref, T);
    EXPECT_EQ(found.of_read, expected.of_read) << seed;
    EXPECT_EQ(found.of_ref, expected.of_ref) << seed;
    EXPECT_GT(found.of_read, 0.02) << seed;
  }
}

TEST(BlockWindow, HoldsWhatTheTreeHolds) {
  for (uint64_t seed = 0; seed < 4; ++seed) {
    OccupancyOctree tree(kVoxelM);
    VoxelMap<OccupancyField> voxels;
    FillAtRandom<OccupancyField>(seed, 60, &tree, &voxels);
    BlockWindow window(tree);
    core::Rng rng(seed);
    for (int i = 0; i < 300; ++i) {
      const auto draw = [&] { return rng.UniformInt(20) - 10; };
      const NodeKey low{draw(), draw(), draw()},
          high{low.x + rng.UniformInt(3), low.y + rng.UniformInt(3), low.z + rng.UniformInt(3)};
      window.MoveTo(low, high);
      bool one_value = true, outside = false;
      for (int k = 0; k < 60; ++k) {
        const NodeKey voxel{8 * low.x - 4 + rng.UniformInt(32), 8 * low.y - 4 + rng.UniformInt(32),
                            8 * low.z - 4 + rng.UniformInt(32)};
        const int8_t held = ValueIn<OccupancyField>(voxels, voxel);
        ASSERT_EQ(window.AtAny(voxel), held);
        outside = outside || !window.Holds(voxel.Up(kBlockLevel));
        if (!window.Holds(voxel.Up(kBlockLevel))) continue;
        ASSERT_EQ(window.At(voxel), held);
        one_value = one_value && held == window.value();
      }
      EXPECT_TRUE(outside);
      EXPECT_TRUE(one_value || !window.one_value());
    }
  }
}

TEST(SubmapOverlap, FreeAndOccupiedAreNotTheSame) {
  OccupancyOctree free(kVoxelM), occupied(kVoxelM);
  free.Set({3, 2, 1}, -40);
  occupied.Set({3, 2, 1}, 71);
  EXPECT_EQ(OverlapOf(free, 1, occupied, 1, Pose::Identity()).of_read, 0.0);
  EXPECT_EQ(OverlapOf(free, 1, free, 1, Pose::Identity()).of_read, 1.0);
}

TEST(SubmapOverlap, BoxesOverlapByVolume) {
  const core::Box3 a{Vec3(0, 0, 0), Vec3(2, 2, 2)}, b{Vec3(1, 1, 0), Vec3(5, 2, 2)},
      far{Vec3(3, 0, 0), Vec3(4, 1, 1)};
  EXPECT_DOUBLE_EQ(OverlapOf(a, b).of_read, 0.25);
  EXPECT_DOUBLE_EQ(OverlapOf(a, b).of_ref, 0.25);
  EXPECT_EQ(OverlapOf(a, far).of_read, 0.0);
  EXPECT_EQ(OverlapOf(a, core::Box3{}).of_read, 0.0);
}

}  // namespace
}  // namespace atlas::tests
