#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "tests/support/random_octree.h"

namespace atlas::mapping {
namespace {

using tests::FillAtRandom;
using tests::ValueIn;
using tests::VoxelMap;

template <typename Field>
class OctreeOf : public ::testing::Test {};
using Fields = ::testing::Types<OccupancyField, TsdfField>;
TYPED_TEST_SUITE(OctreeOf, Fields);

TEST(Morton, CodesRoundTripAndOrderBlocksByParent) {
  core::Rng rng(1);
  for (int i = 0; i < 10000; ++i) {
    const auto draw = [&] { return rng.UniformInt(2 * kChunkKeyOffset) - kChunkKeyOffset; };
    const int x = draw(), y = draw();
    const NodeKey key{x, y, draw()};
    EXPECT_EQ(ChunkKeyOf(ChunkCode(key)), key);
  }
  for (int block = 0; block < kChunkBlocks; ++block) {
    const NodeKey at = BlockOffset(block);
    EXPECT_EQ(BlockIndex(at.x, at.y, at.z), block);
    const NodeKey parent = BlockOffset(block & ~7);
    EXPECT_EQ(at.Up(1), parent.Up(1)) << "eight neighbours in memory share a level 4 node";
    EXPECT_EQ(at.Up(2), BlockOffset(block & ~63).Up(2));
  }
}

TEST(Morton, KeysFloorTowardsMinusInfinity) {
  EXPECT_EQ(VoxelKeyAt(core::Vec3(-0.01, 0.0, 0.049), 20.0), (NodeKey{-1, 0, 0}));
  EXPECT_EQ((NodeKey{-1, -64, 63}).Up(kChunkLevel), (NodeKey{-1, -1, 0}));
  for (int i = 0; i < kBlockVoxels; ++i) {
    const int x = i & 7, y = i >> 3 & 7, z = i >> 6;
    EXPECT_EQ(VoxelIndex(x - 8, y + 16, z), i);
    EXPECT_EQ(CellOfVoxel(i), x / 2 + 4 * (y / 2) + 16 * (z / 2));
  }
}

TEST(ChunkTable, HoldsWhatAPlainMapHolds) {
  core::Rng rng(3);
  ChunkTable<const int> table;
  std::map<std::array<int, 3>, const int*> plain;
  const std::vector<int> targets(1000);
  for (int step = 0; step < 20000; ++step) {
    const auto draw = [&] { return rng.UniformInt(12) - 6; };
    const int x = draw(), y = draw(), z = draw();
    const NodeKey key{x, y, z};
    if (plain.contains({x, y, z})) {
      table.Erase(key);
      plain.erase({x, y, z});
    } else {
      const int* const target = &targets[static_cast<size_t>(step) % targets.size()];
      table.Insert(key, target);
      plain[{x, y, z}] = target;
    }
    ASSERT_EQ(table.size(), plain.size());
    if (step % 500 != 0) continue;
    for (int i = 0; i < 12 * 12 * 12; ++i) {
      const std::array<int, 3> at{i % 12 - 6, i / 12 % 12 - 6, i / 144 - 6};
      const auto found = plain.find(at);
      ASSERT_EQ(table.Find({at[0], at[1], at[2]}), found == plain.end() ? nullptr : found->second);
    }
  }
}

TYPED_TEST(OctreeOf, HoldsWhatAPlainMapOfVoxelsHoldsAtEveryScale) {
  Octree<TypeParam> tree(0.05);
  VoxelMap<TypeParam> voxels;
  FillAtRandom(2, 64, &tree, &voxels);
  const auto counts = tree.Count();
  EXPECT_GT(counts.fine, 0u);
  EXPECT_GT(counts.coarse, 0u);
  EXPECT_GT(counts.uniform_known, 0u);
  size_t known = 0;
  for (int z = -70; z < 70; ++z) {
    for (int y = -70; y < 70; ++y) {
      for (int x = -70; x < 70; ++x) {
        const auto value = tree.At(NodeKey{x, y, z});
        ASSERT_TRUE(value == ValueIn<TypeParam>(voxels, {x, y, z})) << x << " " << y << " " << z;
        known += TypeParam::Known(value);
      }
    }
  }
  EXPECT_EQ(known, voxels.size());
}

TYPED_TEST(OctreeOf, SplittingAndCollapsingKeepEveryVoxel) {
  Octree<TypeParam> tree(0.1);
  VoxelMap<TypeParam> voxels;
  FillAtRandom(3, 32, &tree, &voxels);
  core::Rng rng(4);
  for (const auto* found : tree.Chunks()) {
    auto* chunk = tree.Find(found->key);
    BlockMask all;
    all.bits.fill(~uint64_t{0});
    for (int block = 0; block < kChunkBlocks; ++block) {
      if (rng.UniformInt(2) == 0) tree.MakeFine(chunk, block, 0);
      if (!chunk->fine.Test(block) && rng.UniformInt(2) == 0) tree.MakeCoarse(chunk, block, 0);
    }
    tree.CollapseEqual(chunk, all, 0);
    for (int block = 0; block < kChunkBlocks; ++block) {
      typename Octree<TypeParam>::FineLeaf leaf;
      tree.Expand(*chunk, block, &leaf);
      bool equal = true;
      const NodeKey at = BlockOffset(block);
      for (int i = 0; i < kBlockVoxels; ++i) {
        const NodeKey key{64 * chunk->key.x + 8 * at.x + (i & 7), 64 * chunk->key.y + 8 * at.y + (i >> 3 & 7),
                          64 * chunk->key.z + 8 * at.z + (i >> 6)};
        ASSERT_TRUE(leaf.Get(i) == ValueIn<TypeParam>(voxels, key));
        equal = equal && leaf.Get(i) == leaf.Get(0);
      }
      EXPECT_EQ(chunk->Kind(block) == BlockKind::kUniform, equal) << "collapsed exactly where lossless";
    }
  }
}

/// What a node of `side` voxels should know, voxel by voxel.
struct Brute {
  int max = OccupancyField::kNoneObserved;
  int min_distance = 32767;
  double known = 0.0, distance = 0.0, weight = 0.0, all = 0.0;
};
void Add(OccupancyField::Value v, Brute* b) {
  b->known += OccupancyField::Known(v);
  if (OccupancyField::Known(v)) b->max = std::max<int>(b->max, v);
}
void Add(TsdfField::Value v, Brute* b) {
  if (!TsdfField::Known(v)) return;
  b->known += 1.0;
  b->distance += v.distance;
  b->weight += v.weight;
  b->min_distance = std::min<int>(b->min_distance, v.distance);
}
void ExpectAgrees(const OccupancyField::Node& node, const Brute& b) {
  EXPECT_EQ(node.max, b.max);
  EXPECT_EQ(node.any_unknown, b.known < b.all);
  EXPECT_EQ(OccupancyField::NodeObserved(node), b.known > 0.0);
}
void ExpectAgrees(const TsdfField::Node& node, const Brute& b) {
  EXPECT_EQ(node.any_unknown, b.known < b.all);
  EXPECT_NEAR(node.observed, b.known / b.all, 1e-5);
  if (b.known == 0.0) return;
  EXPECT_EQ(node.min_distance, b.min_distance);
  EXPECT_NEAR(node.mean_distance, b.distance / b.known, 1e-2 + 1e-4 * std::abs(b.distance / b.known));
  EXPECT_NEAR(node.mean_weight, b.weight / b.known, 1e-3 * b.weight / b.known);
}

TYPED_TEST(OctreeOf, SummariesOfLevels3To6AreThoseOfTheVoxelsBelow) {
  Octree<TypeParam> tree(0.05);
  VoxelMap<TypeParam> voxels;
  FillAtRandom(5, 64, &tree, &voxels);
  for (const auto* chunk : tree.Chunks()) {
    for (int level = kBlockLevel; level <= kChunkLevel; ++level) {
      const int blocks = 1 << 3 * (level - kBlockLevel), side = 1 << level;
      for (int block = 0; block < kChunkBlocks; block += blocks) {
        const NodeKey at = BlockOffset(block);
        Brute brute;
        brute.all = side * side * side;
        for (int z = 0; z < side; ++z) {
          for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
              Add(tree.At(NodeKey{64 * chunk->key.x + 8 * at.x + x, 64 * chunk->key.y + 8 * at.y + y,
                                  64 * chunk->key.z + 8 * at.z + z}),
                  &brute);
            }
          }
        }
        const auto index = static_cast<size_t>(block);
        ExpectAgrees(level == 3   ? chunk->BlockNode(block)
                     : level == 4 ? chunk->level4[index / 8]
                     : level == 5 ? chunk->level5[index / 64]
                                  : chunk->level6,
                     brute);
      }
    }
  }
}

TYPED_TEST(OctreeOf, ChunksComeByMortonCodeAndErasedOnesGiveTheirMemoryBack) {
  Octree<TypeParam> tree(0.05);
  const size_t empty = tree.Bytes();
  VoxelMap<TypeParam> voxels;
  FillAtRandom(6, 128, &tree, &voxels);
  const auto chunks = tree.Chunks();
  ASSERT_GT(chunks.size(), 8u);
  for (size_t i = 1; i < chunks.size(); ++i) {
    EXPECT_LT(ChunkCode(chunks[i - 1]->key), ChunkCode(chunks[i]->key));
  }
  const auto counts = tree.Count();
  EXPECT_GE(tree.Bytes(), empty + counts.fine * sizeof(typename Octree<TypeParam>::FineLeaf) +
                              counts.coarse * sizeof(typename Octree<TypeParam>::CoarseLeaf));
  const size_t full = tree.Bytes();
  std::vector<NodeKey> keys;
  for (const auto* chunk : chunks) keys.push_back(chunk->key);
  for (const NodeKey& key : keys) tree.Erase(key);
  EXPECT_EQ(tree.Bytes(), empty);
  EXPECT_EQ(tree.Count().fine + tree.Count().coarse, 0u);
  EXPECT_FALSE(TypeParam::Known(tree.At(NodeKey{0, 0, 0})));
  VoxelMap<TypeParam> again;
  FillAtRandom(6, 128, &tree, &again);
  EXPECT_EQ(tree.Bytes(), full);
}

TYPED_TEST(OctreeOf, ChangesAreReportedOnceByBlock) {
  Octree<TypeParam> tree(0.05);
  core::Rng rng(7);
  tree.Set({-1, 5, 70}, tests::RandomValue<TypeParam>(&rng));
  tree.Set({200, 0, 0}, tests::RandomValue<TypeParam>(&rng));
  const auto changes = tree.TakeChanges();
  ASSERT_EQ(changes.size(), 2u);
  for (const auto& [key, mask] : changes) {
    int blocks = 0;
    for (int b = 0; b < kChunkBlocks; ++b) blocks += mask.Test(b);
    EXPECT_EQ(blocks, 1);
    EXPECT_TRUE(key == (NodeKey{-1, 0, 1}) ? mask.Test(BlockIndex(7, 0, 0)) : mask.Test(BlockIndex(1, 0, 0)));
  }
  EXPECT_TRUE(tree.TakeChanges().empty());
}

TEST(Octree, ResolutionOutOfRangeIsRefused) {
  EXPECT_THROW(OccupancyOctree(0.0), std::invalid_argument);
  EXPECT_THROW(TsdfOctree(std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace atlas::mapping
