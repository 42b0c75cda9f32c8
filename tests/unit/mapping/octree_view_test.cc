// Rays through an octree against a world that sorts plane crossings: every kind of block, whatever is joined.
#include "mapping/octree/octree_view.h"

#include <gtest/gtest.h>

#include <set>

#include "core/rng.h"
#include "tests/support/voxel_world.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = OccupancyField;

constexpr double kVoxelM = 0.05;
/// Across chunks (3.2 m), on both sides of the origin.
const core::Box3 kViewedBox{Vec3(-4.0, -2.4, -1.6), Vec3(4.8, 2.4, 1.6)};

/// The same world as an octree of uniform, coarse and fine blocks and empty chunks, and voxel by voxel.
struct Twins {
  explicit Twins(uint64_t seed) : world(kViewedBox, kVoxelM) {
    core::Rng rng(seed);
    OctreeContents contents{OccupancyOctree(kVoxelM), {}};
    const int8_t values[] = {-40, -36, -20, 12, 71, -8, 0};
    const auto fill = [&](int log2_side, int8_t value) {
      const Vec3 size = kViewedBox.Size();
      const double x = rng.Uniform(), y = rng.Uniform();
      const Vec3 p = kViewedBox.min + size.cwiseProduct(Vec3(x, y, rng.Uniform()));
      const NodeKey corner = contents.tree.KeyAt(p).Up(log2_side);
      for (int i = 0; i < 1 << 3 * log2_side; ++i) {
        const int mask = (1 << log2_side) - 1;
        const NodeKey voxel{(corner.x << log2_side) + (i & mask),
                            (corner.y << log2_side) + (i >> log2_side & mask),
                            (corner.z << log2_side) + (i >> 2 * log2_side)};
        if (!kViewedBox.Contains(contents.tree.CenterOf(voxel))) continue;
        contents.tree.Set(voxel, value);
        world.Set(contents.tree.CenterOf(voxel),
                  Field::Known(value) ? static_cast<float>(Field::Probability(value)) : 0.5f);
      }
    };
    for (int i = 0; i < 10; ++i) fill(5, values[rng.UniformInt(3)]);
    for (int i = 0; i < 60; ++i) fill(3, values[rng.UniformInt(7)]);
    for (int i = 0; i < 300; ++i) fill(rng.UniformInt(3), values[rng.UniformInt(7)]);
    BlockMask all;
    for (int block = 0; block < kChunkBlocks; ++block) all.Set(block);
    for (const auto* chunk : contents.tree.Chunks()) {
      auto* mine = contents.tree.Find(chunk->key);
      contents.tree.CollapseEqual(mine, all, 0);
      contents.tree.Propagate(mine, all);
    }
    counts = contents.tree.Count();
    view.emplace(std::make_shared<const OctreeContents>(std::move(contents)), StateLogOdds{});
  }
  tests::VoxelWorld world;
  std::optional<OctreeView> view;
  OccupancyOctree::Counts counts;
};

struct Shot {
  Vec3 origin, direction;
  TraceLimits limits;
};
Shot Draw(core::Rng* rng) {
  const auto anywhere = [rng](double margin) {
    const core::Box3 box = kViewedBox.Inflated(margin);
    const double x = rng->Uniform(box.min.x(), box.max.x()), y = rng->Uniform(box.min.y(), box.max.y());
    return Vec3(x, y, rng->Uniform(box.min.z(), box.max.z()));
  };
  Shot shot;
  shot.origin = anywhere(1.0);
  shot.direction = (anywhere(0.0) - shot.origin).normalized();
  if (rng->UniformInt(9) == 0)
    shot.direction = (rng->UniformInt(2) ? 1.0 : -1.0) * Vec3::Unit(rng->UniformInt(3));
  shot.limits.max_range_m = rng->Uniform(0.5, 12.0);
  shot.limits.box_map =
      rng->UniformInt(2) ? kViewedBox : core::Box3{Vec3(-1.0, -1.0, -1.0), Vec3(2.0, 1.5, 1.25)};
  return shot;
}

struct Stretch {
  CellState state;
  float occupancy;
  double length_m = 0.0;
  int voxels = 0;
};
/// What the limits let be joined, joined; voxels that the ray only touches left out.
std::vector<Stretch> Joined(const std::vector<RaySample>& samples, const TraceLimits& limits) {
  std::vector<Stretch> stretches;
  for (const RaySample& s : samples) {
    if (s.length_m < 1e-6f) continue;
    bool joins = false;
    if (!stretches.empty() && stretches.back().state == s.state) {
      const bool alike = std::abs(stretches.back().occupancy - s.occupancy) < 1e-4f;
      joins = s.state == CellState::kFree ? alike || !limits.each_free
                                          : !limits.each_unmeasured && alike && s.occupancy == 0.5f;
    }
    if (!joins) stretches.push_back({s.state, s.occupancy});
    stretches.back().length_m += static_cast<double>(s.length_m);
    stretches.back().voxels += static_cast<int>(s.voxels);
  }
  return stretches;
}

class OctreeViewTrace : public ::testing::TestWithParam<std::pair<bool, bool>> {};

TEST_P(OctreeViewTrace, MeetsWhatPlaneCrossingsMeetAndJoinsNoMoreThanItMay) {
  core::Rng rng(31);
  size_t ends = 0, runs = 0, samples_in_all = 0, voxels_in_all = 0;
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const Twins twins(seed);
    ASSERT_GT(twins.counts.fine, 20u);
    ASSERT_GT(twins.counts.uniform_known, 100u);
    for (int trial = 0; trial < 400; ++trial) {
      Shot shot = Draw(&rng);
      std::tie(shot.limits.each_free, shot.limits.each_unmeasured) = GetParam();
      std::vector<RaySample> met, voxels;
      const RayEnd end = twins.view->Trace(shot.origin, shot.direction, shot.limits, &met);
      ASSERT_EQ(end, twins.world.Trace(shot.origin, shot.direction, shot.limits, &voxels))
          << seed << " " << trial;
      const auto expected = Joined(voxels, shot.limits), found = Joined(met, shot.limits);
      ASSERT_EQ(found.size(), expected.size()) << seed << " " << trial;
      for (size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found[i].state, expected[i].state) << seed << " " << trial << " " << i;
        ASSERT_NEAR(found[i].length_m, expected[i].length_m, 1e-4);
        ASSERT_NEAR(found[i].occupancy, expected[i].occupancy, 1e-4);
        ASSERT_NEAR(found[i].voxels, expected[i].voxels, 1) << "voxels met by a corner count or do not";
      }
      for (const RaySample& s : met) {
        runs += s.voxels > 1;
        const bool may = s.state == CellState::kFree || (s.occupancy == 0.5f && !shot.limits.each_unmeasured);
        EXPECT_TRUE(s.voxels == 1 || may);
      }
      samples_in_all += met.size();
      voxels_in_all += voxels.size();
      ends += end == RayEnd::kOccupied;
    }
  }
  EXPECT_GT(ends, 60u);
  EXPECT_GT(runs, 500u);
  const auto [each_free, each_unmeasured] = GetParam();
  if (!each_free && !each_unmeasured) {
    EXPECT_LT(8 * samples_in_all, voxels_in_all);
  }
}

INSTANTIATE_TEST_SUITE_P(Limits, OctreeViewTrace,
                         ::testing::Values(std::pair(true, true), std::pair(false, true),
                                           std::pair(true, false), std::pair(false, false)));

TEST(OctreeView, AVoxelHasOneKeyWhicheverRayMeetsIt) {
  const Twins twins(7);
  core::Rng rng(8);
  std::map<uint64_t, Vec3> centre_of;
  std::set<std::array<int, 3>> seen;
  std::vector<RaySample> met;
  for (int trial = 0; trial < 500; ++trial) {
    Shot shot = Draw(&rng);
    twins.view->Trace(shot.origin, shot.direction, shot.limits, &met);
    double t = 0.0;
    const auto span = shot.limits.box_map.Clip(shot.origin, shot.direction);
    if (span) t = span->first;
    for (const RaySample& s : met) {
      const double length = static_cast<double>(s.length_m);
      if (s.voxels == 1 && length > 0.01) {
        const Vec3 p = shot.origin + (t + 0.5 * length) * shot.direction;
        const Vec3 centre = kVoxelM * ((p / kVoxelM).array().floor() + 0.5);
        const auto [found, added] = centre_of.try_emplace(s.key, centre);
        EXPECT_LT((found->second - centre).norm(), 1e-6) << "one key, two voxels";
      }
      t += length;
    }
  }
  std::set<std::tuple<long, long, long>> distinct;
  for (const auto& [key, c] : centre_of)
    distinct.insert({std::lround(c.x() / kVoxelM * 2), std::lround(c.y() / kVoxelM * 2),
                     std::lround(c.z() / kVoxelM * 2)});
  EXPECT_EQ(distinct.size(), centre_of.size()) << "two keys, one voxel";
  EXPECT_GT(centre_of.size(), 1000u);
}

TEST(OctreeView, OccupiedCentresAreThoseOfTheBox) {
  const Twins twins(9);
  const core::Box3 box{Vec3(-2.0, -1.1, -0.7), Vec3(1.9, 1.3, 1.2)};
  const auto sorted = [](std::vector<core::Vec3f> points) {
    std::sort(points.begin(), points.end(), [](const core::Vec3f& a, const core::Vec3f& b) {
      return std::tuple(std::lround(a.x() * 1e3f), std::lround(a.y() * 1e3f), a.z()) <
             std::tuple(std::lround(b.x() * 1e3f), std::lround(b.y() * 1e3f), b.z());
    });
    return points;
  };
  const auto found = sorted(OccupiedCenters(*twins.view, box)),
             expected = sorted(OccupiedCenters(twins.world, box));
  ASSERT_GT(expected.size(), 100u);
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_LT((found[i] - expected[i]).norm(), 1e-3f);
}

TEST(Octree, ACloneHoldsTheSameAndSharesNothing) {
  const core::Rng seed(3);
  OccupancyOctree tree(kVoxelM);
  core::Rng rng(3);
  for (int i = 0; i < 3000; ++i) {
    tree.Set({rng.UniformInt(200) - 100, rng.UniformInt(200) - 100, rng.UniformInt(60)},
             static_cast<int8_t>(rng.UniformInt(100) - 40));
  }
  BlockMask all;
  for (int block = 0; block < kChunkBlocks; ++block) all.Set(block);
  for (const auto* chunk : tree.Chunks()) tree.Propagate(tree.Find(chunk->key), all);
  OccupancyOctree copy = tree.Clone();
  ASSERT_EQ(copy.chunk_count(), tree.chunk_count());
  size_t known = 0;
  for (int x = -100; x < 100; ++x) {
    for (int y = -100; y < 100; y += 3) {
      for (int z = 0; z < 60; z += 2) {
        ASSERT_EQ(copy.At(NodeKey{x, y, z}), tree.At(NodeKey{x, y, z}));
        known += OccupancyField::Known(tree.At(NodeKey{x, y, z}));
      }
    }
  }
  EXPECT_GT(known, 100u);
  for (const auto* chunk : tree.Chunks()) {
    const auto* other = copy.Find(chunk->key);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(other->level6, chunk->level6);
    for (int block = 0; block < kChunkBlocks; ++block)
      EXPECT_EQ(other->BlockNode(block), chunk->BlockNode(block));
  }
  const int8_t was = tree.At(NodeKey{5, 5, 5});
  copy.Set({5, 5, 5}, 71);
  EXPECT_EQ(tree.At(NodeKey{5, 5, 5}), was);
}

}  // namespace
}  // namespace atlas::mapping
