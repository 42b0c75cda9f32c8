#include "mapping/io/map_file.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>
#include <unistd.h>

#include <fstream>
#include <set>

#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/rng.h"

namespace atlas::mapping {
namespace {

namespace fs = std::filesystem;

OccupancyField::Value RandomValue(core::Rng* rng, OccupancyField) {
  const int v = static_cast<int>(rng->Uniform(-40.0, 71.0));
  return static_cast<int8_t>(v);
}
TsdfField::Value RandomValue(core::Rng* rng, TsdfField) {
  if (rng->Uniform(0.0, 1.0) < 0.3) return {};
  return {static_cast<int16_t>(rng->Uniform(-32000.0, 32000.0)),
          static_cast<uint8_t>(rng->Uniform(1.0, 100.0))};
}

/// Blocks of every kind in chunks on all sides of the origin, some chunks without anything known.
template <typename Field>
Octree<Field> RandomMap(uint64_t seed, const std::vector<NodeKey>& chunks) {
  Octree<Field> map(0.1);
  for (const NodeKey& key : chunks) {
    core::Rng rng(seed + ChunkCode(key));
    auto* chunk = map.FindOrCreate(key);
    BlockMask all;
    for (int block = 0; block < kChunkBlocks; ++block) {
      all.Set(block);
      const double kind = rng.Uniform(0.0, 1.0);
      if (kind < 0.5) {
        map.MakeUniform(chunk, block, RandomValue(&rng, Field{}), 0);
      } else if (kind < 0.55) {
        auto& leaf = map.MakeCoarse(chunk, block, 0);
        for (int i = 0; i < 64; ++i) leaf.Set(i, RandomValue(&rng, Field{}));
      } else if (kind < 0.6) {
        auto& leaf = map.MakeFine(chunk, block, 0);
        for (int i = 0; i < kBlockVoxels; ++i) leaf.Set(i, RandomValue(&rng, Field{}));
      }
    }
    map.Propagate(chunk, all);
  }
  map.FindOrCreate({7, 7, 7});
  return map;
}

const std::vector<NodeKey> kChunks = {{0, 0, 0}, {-1, 0, 0}, {3, -2, 1}, {-5, -5, -5}, {0, 0, -1}};

class MapFile : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(dir_); }
  void TearDown() override { fs::remove_all(dir_); }
  fs::path At(const std::string& name) const { return dir_ / name; }

  template <typename Field>
  std::string BytesOf(const Octree<Field>& map) {
    WriteMap(At("bytes.atlas"), map);
    return core::ReadFile(At("bytes.atlas"));
  }

  /// The one-line refusal of these bytes.
  static std::string Refusal(const std::string& bytes) {
    try {
      ParseMap(bytes, "some.atlas");
    } catch (const core::InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      EXPECT_TRUE(std::string(error.what()).starts_with("some.atlas: ")) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "was read";
    return "";
  }

  fs::path dir_ = fs::temp_directory_path() / ("atlas_map_file_" + std::to_string(::getpid()));
};

template <typename Field>
void ExpectSameVoxels(const Octree<Field>& a, const Octree<Field>& b) {
  EXPECT_EQ(a.resolution_m(), b.resolution_m());
  typename Octree<Field>::FineLeaf leaf;
  for (const auto& [from, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    for (const auto* chunk : from->Chunks()) {
      for (int block = 0; block < kChunkBlocks; ++block) {
        from->Expand(*chunk, block, &leaf);
        const NodeKey offset = BlockOffset(block);
        for (int i = 0; i < kBlockVoxels; ++i) {
          const NodeKey voxel{64 * chunk->key.x + 8 * offset.x + (i & 7),
                              64 * chunk->key.y + 8 * offset.y + (i >> 3 & 7),
                              64 * chunk->key.z + 8 * offset.z + (i >> 6)};
          ASSERT_TRUE(leaf.Get(i) == other->At(voxel));
        }
      }
    }
  }
}

template <typename Field>
class MapFileOf : public MapFile {};
using Fields = ::testing::Types<OccupancyField, TsdfField>;
TYPED_TEST_SUITE(MapFileOf, Fields);

TYPED_TEST(MapFileOf, WhatIsReadEqualsWhatWasWrittenVoxelByVoxel) {
  const auto map = RandomMap<TypeParam>(1, kChunks);
  WriteMap(this->At("map.atlas"), map);
  const AnyOctree any = ReadMap(this->At("map.atlas"));
  const auto& read = std::get<Octree<TypeParam>>(any);
  ExpectSameVoxels(map, read);
  EXPECT_EQ(read.chunk_count(), kChunks.size()) << "chunks without anything known are not stored";
  EXPECT_EQ(read.Count().fine, map.Count().fine);
  EXPECT_EQ(read.Count().coarse, map.Count().coarse);
  for (const auto* chunk : read.Chunks()) {
    const auto* written = map.Find(chunk->key);
    EXPECT_TRUE(chunk->level6 == written->level6);
    EXPECT_TRUE(chunk->level4 == written->level4);
  }
}

TYPED_TEST(MapFileOf, BytesDependOnTheMapAlone) {
  const auto map = RandomMap<TypeParam>(2, kChunks);
  const std::string bytes = this->BytesOf(map);
  EXPECT_EQ(this->BytesOf(RandomMap<TypeParam>(2, {kChunks.rbegin(), kChunks.rend()})), bytes);
  const AnyOctree read = ParseMap(bytes, "map");
  EXPECT_EQ(this->BytesOf(std::get<Octree<TypeParam>>(read)), bytes);

  // A block that was split and made uniform again leaves no trace; nor does the value of an unknown voxel.
  auto touched = RandomMap<TypeParam>(2, kChunks);
  auto* chunk = touched.Find(kChunks[0]);
  for (int block = 0; block < kChunkBlocks; ++block) {
    if (chunk->Kind(block) != BlockKind::kUniform) continue;
    const auto value = chunk->uniform.Get(block);
    touched.MakeFine(chunk, block, 0);
    touched.MakeUniform(chunk, block, value, 0);
  }
  touched.MakeFine(touched.FindOrCreate({9, 9, 9}), 5, 0);
  EXPECT_EQ(this->BytesOf(touched), bytes);
}

TYPED_TEST(MapFileOf, EveryFlippedBitIsFound) {
  const std::string bytes = this->BytesOf(RandomMap<TypeParam>(3, {{0, 0, 0}, {1, 0, 0}}));
  core::Rng rng(3);
  for (int trial = 0; trial < 400; ++trial) {
    const size_t at = trial < 200 ? static_cast<size_t>(trial)
                                  : static_cast<size_t>(rng.Uniform(0.0, static_cast<double>(bytes.size())));
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 1 << (trial & 7));
    this->Refusal(flipped);
  }
}

TYPED_TEST(MapFileOf, EveryTruncationIsFound) {
  const std::string bytes = this->BytesOf(RandomMap<TypeParam>(4, {{0, 0, 0}}));
  for (size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 997)
    this->Refusal(bytes.substr(0, size));
  EXPECT_NE(this->Refusal(bytes + "x").find("1 bytes after its end"), std::string::npos);
}

TEST_F(MapFile, EmptyMapsTravelToo) {
  const std::string bytes = BytesOf(OccupancyOctree(0.05));
  EXPECT_EQ(std::get<OccupancyOctree>(ParseMap(bytes, "map")).chunk_count(), 0u);
}

TEST_F(MapFile, ChecksumIsThatOfXz) {
  EXPECT_EQ(core::Crc64("123456789"), 0x995dc9bbdf1939fau);
  EXPECT_EQ(core::Crc64("56789", core::Crc64("1234")), 0x995dc9bbdf1939fau);
  std::string text(1000, 'x');
  uint64_t by_byte = 0;
  for (const char& c : text) by_byte = core::Crc64({&c, 1}, by_byte);
  EXPECT_EQ(core::Crc64(text), by_byte);
}

/// The header (80 bytes) with a right checksum again.
std::string Resealed(std::string bytes) {
  const uint64_t crc = core::Crc64(std::string_view(bytes).substr(0, 80));
  std::memcpy(bytes.data() + 80, &crc, 8);
  return bytes;
}
template <typename T>
std::string With(std::string bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(value));
  return Resealed(std::move(bytes));
}

TEST_F(MapFile, RefusalsNameWhatIsWrong) {
  const std::string bytes = BytesOf(RandomMap<OccupancyField>(5, {{0, 0, 0}}));
  const auto expect = [&](const std::string& broken, const std::string& words) {
    const std::string refusal = Refusal(broken);
    EXPECT_NE(refusal.find(words), std::string::npos) << refusal;
  };
  expect("ply\nformat ascii 1.0\n", "not a map file");
  expect("", "not a map file");
  expect(With(bytes, 8, uint32_t{7}), "newer version: format 7, this program reads up to 1");
  expect(With(bytes, 8, uint32_t{0}), "format version 0");
  expect(With(bytes, 12, uint32_t{2}), "field 2");
  expect(With(bytes, 16, 0.0), "resolution 0 m, must be 0.001 to 10");
  expect(With(bytes, 16, std::nan("")), "resolution nan m");
  expect(With(bytes, 16, 1e300), "must be 0.001 to 10");
  expect(With(bytes, 24, ~uint64_t{0}), "18446744073709551615 chunks, at most");
  expect(With(bytes, 24, uint64_t{2}), "2 chunks announced, 1 there");
  expect(With(bytes, 32, uint64_t{1} << 40), "fine leaves announced");
  expect(With(bytes, 56, int32_t{-9}), "bounds differ");
  expect(With(bytes, 88, uint32_t{65}), "65 chunks, must be 1 to 64");
  expect(With(bytes, 92, ~uint32_t{0}), "4294967295 bytes, at most");
  expect(With(bytes, 96, ~uint32_t{0}), "ends early");
}

TEST_F(MapFile, FailedWritesLeaveTheOldFile) {
  core::WriteFileAtomically(At("blocker"), "a file");
  EXPECT_THROW(WriteMap(At("blocker") / "map.atlas", OccupancyOctree(0.1)), core::InputError);
  EXPECT_EQ(core::ReadFile(At("blocker")), "a file");
  fs::create_directories(At("folder.atlas"));
  EXPECT_THROW(WriteMap(At("folder.atlas"), OccupancyOctree(0.1)), core::InputError);
  size_t left = 0;
  for ([[maybe_unused]] const auto& entry : fs::directory_iterator(dir_)) ++left;
  EXPECT_EQ(left, 2u) << "something was left beside";
}

// --- Exports, read back by liboctomap.

template <typename Field>
void ExpectSameStates(const Octree<Field>& map, const octomap::OcTree& tree) {
  core::Rng rng(11);
  size_t known = 0;
  for (int trial = 0; trial < 60000; ++trial) {
    const NodeKey& chunk = kChunks[static_cast<size_t>(trial) % kChunks.size()];
    const core::Vec3 p =
        6.4 * (core::Vec3(chunk.x, chunk.y, chunk.z) +
               core::Vec3(rng.Uniform(-0.1, 1.1), rng.Uniform(-0.1, 1.1), rng.Uniform(-0.1, 1.1)));
    const auto value = map.At(p);
    const octomap::OcTreeNode* node = tree.search(p.x(), p.y(), p.z());
    ASSERT_EQ(node != nullptr, Field::Known(value)) << p.transpose();
    if (node == nullptr) continue;
    ++known;
    ASSERT_EQ(tree.isNodeOccupied(node), Field::Occupied(value)) << p.transpose();
  }
  EXPECT_GT(known, 10000u);
}

TYPED_TEST(MapFileOf, OctomapReadsTheSameStatesFromBt) {
  const auto map = RandomMap<TypeParam>(6, kChunks);
  ExportOctomap(this->At("map.bt"), map);
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(this->At("map.bt")));
  EXPECT_DOUBLE_EQ(tree.getResolution(), 0.1);
  EXPECT_EQ(tree.calcNumNodes(), tree.size());
  ExpectSameStates(map, tree);
  const size_t nodes = tree.size();
  tree.prune();
  EXPECT_EQ(tree.size(), nodes) << "was not pruned";
}

TYPED_TEST(MapFileOf, OctomapReadsTheSameStatesFromOt) {
  const auto map = RandomMap<TypeParam>(7, kChunks);
  ExportOctomap(this->At("map.ot"), map);
  const std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(this->At("map.ot")));
  auto* tree = dynamic_cast<octomap::OcTree*>(any.get());
  ASSERT_NE(tree, nullptr);
  ExpectSameStates(map, *tree);
  const std::string header = core::ReadFile(this->At("map.ot"));
  EXPECT_NE(header.find("\nsize " + std::to_string(tree->calcNumNodes()) + "\n"), std::string::npos);
  const float before = tree->getRoot()->getLogOdds();
  tree->updateInnerOccupancy();
  EXPECT_EQ(tree->getRoot()->getLogOdds(), before) << "inner nodes hold the greatest below";
  const size_t nodes = tree->size();
  tree->prune();
  EXPECT_EQ(tree->size(), nodes) << "was not pruned";
}

TEST_F(MapFile, OtKeepsLogOdds) {
  const auto map = RandomMap<OccupancyField>(8, kChunks);
  ExportOctomap(At("map.ot"), map);
  const std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(At("map.ot")));
  auto* tree = dynamic_cast<octomap::OcTree*>(any.get());
  ASSERT_NE(tree, nullptr);
  size_t leaves = 0;
  for (auto leaf = tree->begin_leafs(), end = tree->end_leafs(); leaf != end; ++leaf, ++leaves) {
    const auto p = leaf.getCoordinate();
    ASSERT_FLOAT_EQ(leaf->getLogOdds(),
                    static_cast<float>(OccupancyField::LogOdds(map.At(core::Vec3(p.x(), p.y(), p.z())))));
  }
  EXPECT_GT(leaves, 1000u);
}

TEST_F(MapFile, UniformBlocksBecomePrunedNodes) {
  OccupancyOctree map(0.1);
  auto* chunk = map.FindOrCreate({0, 0, 0});
  for (int block = 0; block < kChunkBlocks; ++block) map.MakeUniform(chunk, block, -40, 0);
  ExportOctomap(At("map.bt"), map);
  octomap::OcTree tree(1.0);
  ASSERT_TRUE(tree.readBinary(At("map.bt")));
  EXPECT_EQ(tree.size(), 11u) << "a root, nine inner nodes and one leaf of 64 voxels a side";
}

TEST_F(MapFile, ExportsOutOfReachAreRefused) {
  OccupancyOctree far(0.1);
  far.Set({64 * 512, 0, 0}, 5);
  EXPECT_THROW(ExportOctomap(At("far.bt"), far), core::InputError);
  EXPECT_THROW(ExportOctomap(At("empty.bt"), OccupancyOctree(0.1)), core::InputError);
  far = OccupancyOctree(0.1);
  far.Set({64 * 512 - 1, -64 * 512, 0}, 5);
  ExportOctomap(At("far.bt"), far);
  EXPECT_THROW(ExportOctomap(At("map.xyz"), far), core::InputError);
  EXPECT_FALSE(fs::exists(At("empty.bt")));
}

TYPED_TEST(MapFileOf, SurfaceVoxelsAreThoseThatAVoxelByVoxelCountFinds) {
  const auto map = RandomMap<TypeParam>(9, {{0, 0, 0}, {-1, -1, -1}});
  std::set<std::array<int, 3>> expected;
  for (int z = -64; z < 64; ++z) {
    for (int y = -64; y < 64; ++y) {
      for (int x = -64; x < 64; ++x) {
        const auto v = map.At(NodeKey{x, y, z});
        if constexpr (std::is_same_v<TypeParam, OccupancyField>) {
          if (v > 0) expected.insert({x, y, z});
        } else {
          if (v.weight > 0 && std::abs(v.distance) * 24.0 / 32767.0 <= 1.0) expected.insert({x, y, z});
        }
      }
    }
  }
  std::set<std::array<int, 3>> found;
  const core::PointCloud cloud = SurfaceVoxels(map);
  for (const core::Vec3f& p : cloud.points) {
    const NodeKey key = map.KeyAt(p.template cast<double>());
    EXPECT_TRUE(found.insert({key.x, key.y, key.z}).second);
  }
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace atlas::mapping
