// Many submaps asked as one, against submaps that are plain tables of voxels.
#include "mapping/atlas/atlas_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/rng.h"

namespace atlas::tests {
namespace {

using namespace mapping;
using core::Pose;
using core::Vec3;

constexpr double kVoxelM = 0.1;
constexpr int8_t kFreeSteps = -40, kOccupiedSteps = 71;

/// A submap as a table: voxel to free or occupied; what is not in it was never measured.
struct Table {
  std::map<std::array<int, 3>, CellState> voxels;
  Pose T_map_submap;

  CellState At(const Vec3& p_map) const {
    const Vec3 p = T_map_submap.inverse() * p_map / kVoxelM;
    const auto found = voxels.find({static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                                    static_cast<int>(std::floor(p.z()))});
    return found == voxels.end() ? CellState::kUnknown : found->second;
  }
};

/// Newest first.
CellState StateIn(const std::vector<Table>& tables, const Vec3& p_map) {
  for (const Table& table : tables) {
    if (const CellState state = table.At(p_map); state != CellState::kUnknown) return state;
  }
  return CellState::kUnknown;
}

Table RandomTable(core::Rng* rng) {
  Table table;
  for (int i = 0; i < 2500; ++i) {
    const auto at = [&] { return static_cast<int>(std::floor(rng->Uniform(-10.0, 10.0))); };
    const std::array<int, 3> voxel = {at(), at(), at()};
    table.voxels[voxel] = rng->Uniform(0.0, 1.0) < 0.15 ? CellState::kOccupied : CellState::kFree;
  }
  const core::Mat3 R = core::RotationFromYawPitchRoll(rng->Uniform(-3.0, 3.0), rng->Uniform(-0.3, 0.3),
                                                      rng->Uniform(-0.3, 0.3));
  table.T_map_submap =
      core::MakePose(R, Vec3(rng->Uniform(-0.5, 0.5), rng->Uniform(-0.5, 0.5), rng->Uniform(-0.2, 0.2)));
  return table;
}

OctreeContents ContentsOf(const Table& table) {
  OccupancyOctree tree(kVoxelM);
  for (const auto& [voxel, state] : table.voxels) {
    tree.Set({voxel[0], voxel[1], voxel[2]}, state == CellState::kFree ? kFreeSteps : kOccupiedSteps);
  }
  BlockMask all;
  all.bits.fill(~uint64_t{0});
  for (const OccupancyOctree::Chunk* chunk : tree.Chunks()) tree.Propagate(tree.Find(chunk->key), all);
  return {std::move(tree), {}};
}

OctreeView ViewOf(const Table& table) {
  return {std::make_shared<const OctreeContents>(ContentsOf(table)), {}};
}

core::Box3 Everywhere() {
  return TraceLimits{}.box_map;
}

AtlasView AtlasOf(const std::vector<Table>& tables, const core::Box3& keep) {
  std::vector<PosedSubmap> submaps;
  const auto pager = std::make_shared<ContentsPager>(0);
  for (const Table& table : tables) {
    const auto id = static_cast<uint32_t>(submaps.size());
    OctreeContents contents = ContentsOf(table);
    auto outline = std::make_shared<const SubmapOutline>(OutlineOf(contents));
    submaps.push_back({id, std::make_shared<const StoredContents>(pager, std::move(contents)), StateLogOdds{},
                       table.T_map_submap, std::move(outline)});
  }
  return {kVoxelM, std::move(submaps), keep};
}

struct Worlds : ::testing::TestWithParam<int> {
  Worlds() : rng(static_cast<uint64_t>(GetParam())) {
    for (int i = 0; i < 1 + GetParam() % 4; ++i) tables.push_back(RandomTable(&rng));
  }
  Vec3 Point(double reach) {
    return {rng.Uniform(-reach, reach), rng.Uniform(-reach, reach), rng.Uniform(-reach, reach)};
  }
  core::Rng rng;
  std::vector<Table> tables;
};

INSTANTIATE_TEST_SUITE_P(Random, Worlds, ::testing::Range(0, 12));

TEST_P(Worlds, APointIsWhatTheNewestSubmapThatMeasuredItHolds) {
  const AtlasView atlas = AtlasOf(tables, Everywhere());
  int seen[3] = {0, 0, 0};
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = Point(1.6);
    const CellState expected = StateIn(tables, p);
    EXPECT_EQ(atlas.StateAt(p), expected) << p.transpose();
    ++seen[static_cast<int>(expected)];
  }
  EXPECT_GT(std::min({seen[0], seen[1], seen[2]}), 20);
}

TEST_P(Worlds, ARayMeetsWhatItsPointsAreUpToTheFirstOccupiedOne) {
  const AtlasView atlas = AtlasOf(tables, Everywhere());
  std::vector<RaySample> samples;
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin = Point(2.0), direction = (Point(0.8) - origin).normalized();
    TraceLimits limits;
    limits.max_range_m = 4.0;
    limits.each_free = i % 2 == 0;
    limits.each_unmeasured = i % 3 == 0;
    const RayEnd end = atlas.Trace(origin, direction, limits, &samples);
    double t = 0.0;
    for (size_t k = 0; k < samples.size(); ++k) {
      const double length = samples[k].length_m;
      for (const double share : {0.05, 0.5, 0.95}) {
        const Vec3 p = origin + (t + share * length) * direction;
        if (length < 1e-4) continue;
        ASSERT_EQ(samples[k].state, StateIn(tables, p)) << "ray " << i << " sample " << k;
      }
      EXPECT_TRUE(samples[k].state != CellState::kOccupied || k + 1 == samples.size());
      t += length;
    }
    ASSERT_EQ(end == RayEnd::kOccupied, !samples.empty() && samples.back().state == CellState::kOccupied);
    if (end == RayEnd::kVoid) {
      EXPECT_NEAR(t, 4.0, 1e-3);
    }
  }
}

TEST_P(Worlds, OccupiedVoxelsAreThoseThatNoNewerSubmapDenies) {
  const core::Box3 box{Vec3(-0.7, -0.9, -0.6), Vec3(0.8, 0.6, 0.9)};
  std::vector<Vec3> expected;
  for (size_t i = 0; i < tables.size(); ++i) {
    for (const auto& [voxel, state] : tables[i].voxels) {
      const Vec3 center =
          tables[i].T_map_submap * (kVoxelM * (Vec3(voxel[0], voxel[1], voxel[2]).array() + 0.5)).matrix();
      const std::vector<Table> newer(tables.begin(), tables.begin() + static_cast<std::ptrdiff_t>(i));
      if (state == CellState::kOccupied && box.Contains(center) &&
          StateIn(newer, center) == CellState::kUnknown)
        expected.push_back(center);
    }
  }
  std::vector<core::Vec3f> found;
  AtlasOf(tables, Everywhere()).ForEachOccupied(box, [&](const core::Vec3f& p) { found.push_back(p); });
  ASSERT_EQ(found.size(), expected.size());
  for (const Vec3& center : expected) {
    EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](const core::Vec3f& p) {
      return (p.cast<double>() - center).norm() < 1e-5;
    })) << center.transpose();
  }
}

TEST_P(Worlds, NothingIsKnownOutsideOfWhatIsKept) {
  const core::Box3 keep{Vec3(-0.3, -0.5, -0.4), Vec3(0.6, 0.2, 0.5)};
  const AtlasView atlas = AtlasOf(tables, keep);
  std::vector<RaySample> samples;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = Point(1.0);
    EXPECT_EQ(atlas.StateAt(p), keep.Contains(p) ? StateIn(tables, p) : CellState::kUnknown);
    const Vec3 direction = Point(1.0).normalized();
    TraceLimits limits;
    limits.max_range_m = 2.0;
    atlas.Trace(p, direction, limits, &samples);
    double t = 0.0;
    for (const RaySample& sample : samples) {
      const Vec3 middle = p + (t + 0.5 * static_cast<double>(sample.length_m)) * direction;
      EXPECT_TRUE(keep.Inflated(1e-4).Contains(middle) || sample.state == CellState::kUnknown);
      t += static_cast<double>(sample.length_m);
    }
  }
}

TEST(AtlasView, OneSubmapWhereTheMapIsIsThatSubmap) {
  core::Rng rng(7);
  Table table = RandomTable(&rng);
  table.T_map_submap = Pose::Identity();
  const OctreeView alone = ViewOf(table);
  const AtlasView atlas = AtlasOf({table}, Everywhere());
  std::vector<RaySample> expected, found;
  for (int i = 0; i < 300; ++i) {
    const Vec3 origin(rng.Uniform(-0.9, 0.9), rng.Uniform(-0.9, 0.9), rng.Uniform(-0.9, 0.9));
    const Vec3 direction = Vec3(rng.Normal(), rng.Normal(), rng.Normal()).normalized();
    TraceLimits limits;
    limits.max_range_m = 3.0;
    limits.each_unmeasured = i % 2 == 0;
    const RayEnd end = alone.Trace(origin, direction, limits, &expected);
    ASSERT_EQ(atlas.Trace(origin, direction, limits, &found), end);
    uint64_t voxels = 0, found_voxels = 0;
    for (const RaySample& s : expected) voxels += s.state == CellState::kFree ? s.voxels : 0;
    for (const RaySample& s : found) found_voxels += s.state == CellState::kFree ? s.voxels : 0;
    EXPECT_NEAR(static_cast<double>(found_voxels), static_cast<double>(voxels), 1.0);
    EXPECT_TRUE(!limits.each_unmeasured || found.size() == expected.size());
  }
}

}  // namespace
}  // namespace atlas::tests
