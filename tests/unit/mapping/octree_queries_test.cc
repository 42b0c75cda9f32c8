#include <gtest/gtest.h>

#include <algorithm>

#include "mapping/octree/queries.h"
#include "tests/support/random_octree.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using tests::FillAtRandom;
using tests::VoxelMap;

constexpr double kRes = 0.05;

template <typename Field>
class QueriesOf : public ::testing::Test {
 protected:
  void SetUp() override { FillAtRandom(11, 64, &tree_, &voxels_); }
  Octree<Field> tree_{kRes};
  VoxelMap<Field> voxels_;
};
using Fields = ::testing::Types<OccupancyField, TsdfField>;
TYPED_TEST_SUITE(QueriesOf, Fields);

Vec3 DrawPoint(core::Rng* rng, double reach) {
  const double x = rng->Uniform(-reach, reach), y = rng->Uniform(-reach, reach);
  return {x, y, rng->Uniform(-reach, reach)};
}

/// Every fifth along an axis or in a plane, where rays run along faces of voxels.
Vec3 DrawDirection(core::Rng* rng) {
  Vec3 d(rng->Normal(), rng->Normal(), rng->Normal());
  if (rng->UniformInt(5) == 0) d[rng->UniformInt(3)] = 0.0;
  if (rng->UniformInt(5) == 0) d = Vec3::Unit(rng->UniformInt(3));
  return d.normalized();
}

/// Sorted distances at which the ray meets planes of voxels: unlike any DDA.
std::vector<double> Crossings(const Vec3& origin, const Vec3& direction, double range_m) {
  std::vector<double> cuts = {0.0, range_m};
  for (int a = 0; a < 3; ++a) {
    if (direction[a] == 0.0) continue;
    const double end = origin[a] + range_m * direction[a];
    const int lo = static_cast<int>(std::floor(std::min(origin[a], end) / kRes));
    const int hi = static_cast<int>(std::ceil(std::max(origin[a], end) / kRes));
    for (int plane = lo; plane <= hi; ++plane) {
      const double t = (plane * kRes - origin[a]) / direction[a];
      if (t > 0.0 && t < range_m) cuts.push_back(t);
    }
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

TYPED_TEST(QueriesOf, TraceHoldsTheValueOfEveryVoxelCrossed) {
  core::Rng rng(12);
  int whole_nodes = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Vec3 origin = DrawPoint(&rng, 4.0), direction = DrawDirection(&rng);
    const double range_m = rng.Uniform(0.5, 9.0);
    std::vector<RaySegment<TypeParam>> segments;
    TraceRay(this->tree_, origin, direction, range_m, [&](const auto& segment) {
      segments.push_back(segment);
      return true;
    });
    ASSERT_FALSE(segments.empty());
    EXPECT_EQ(segments.front().t_begin_m, 0.0);
    EXPECT_EQ(segments.back().t_end_m, range_m);
    for (size_t i = 1; i < segments.size(); ++i) EXPECT_EQ(segments[i].t_begin_m, segments[i - 1].t_end_m);
    for (const auto& segment : segments) whole_nodes += segment.level >= 4;
    const std::vector<double> cuts = Crossings(origin, direction, range_m);
    size_t at = 0;
    for (size_t i = 0; i + 1 < cuts.size(); ++i) {
      if (cuts[i + 1] - cuts[i] < 1e-6) continue;
      const double t = 0.5 * (cuts[i] + cuts[i + 1]);
      while (segments[at].t_end_m < t) ++at;
      EXPECT_TRUE(segments[at].value == this->tree_.At(Vec3(origin + t * direction))) << trial << " " << t;
    }
  }
  EXPECT_GT(whole_nodes, 400) << "nodes above blocks are crossed in one step";
}

TYPED_TEST(QueriesOf, TraceStopsWhenAsked) {
  int visits = 0;
  TraceRay(this->tree_, Vec3(0.01, 0.02, 0.03), Vec3::UnitX().eval(), 5.0,
           [&](const auto&) { return ++visits < 2; });
  EXPECT_EQ(visits, 2);
}

TYPED_TEST(QueriesOf, FirstOccupiedIsTheFirstOccupiedVoxelCrossed) {
  core::Rng rng(13);
  int met = 0, grazed = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const Vec3 origin = DrawPoint(&rng, 4.0), direction = DrawDirection(&rng);
    const double range_m = rng.Uniform(0.5, 9.0);
    const auto found = FirstOccupied(this->tree_, origin, direction, range_m);
    const std::vector<double> cuts = Crossings(origin, direction, range_m);
    std::optional<double> expected;
    for (size_t i = 0; i + 1 < cuts.size() && !expected; ++i) {
      if (cuts[i + 1] - cuts[i] < 1e-6) continue;  // a corner may be grazed or not
      const Vec3 p = origin + 0.5 * (cuts[i] + cuts[i + 1]) * direction;
      if (TypeParam::Occupied(this->tree_.At(p))) expected = cuts[i];
    }
    if (found && (!expected || *found < *expected - 1e-6)) {
      EXPECT_TRUE(TypeParam::Occupied(this->tree_.At(Vec3(origin + (*found + 1e-9) * direction))))
          << "a corner";
      ++grazed;
      continue;
    }
    ASSERT_EQ(found.has_value(), expected.has_value()) << trial;
    EXPECT_NEAR(found.value_or(-1.0), expected.value_or(-1.0), 1e-6);
    met += found.has_value();
  }
  EXPECT_GT(met, 60);
  EXPECT_LT(grazed, 5);
}

/// The state of all voxels for which `meets(key)`.
template <typename Field, typename Meets>
CellState BruteState(const Octree<Field>& tree, const NodeKey& lo, const NodeKey& hi, const Meets& meets) {
  bool unknown = false;
  for (int z = lo.z; z <= hi.z; ++z) {
    for (int y = lo.y; y <= hi.y; ++y) {
      for (int x = lo.x; x <= hi.x; ++x) {
        if (!meets(NodeKey{x, y, z})) continue;
        const auto value = tree.At(NodeKey{x, y, z});
        if (Field::Occupied(value)) return CellState::kOccupied;
        unknown = unknown || !Field::Known(value);
      }
    }
  }
  return unknown ? CellState::kUnknown : CellState::kFree;
}

TYPED_TEST(QueriesOf, StateOfABoxIsThatOfItsVoxels) {
  core::Rng rng(14);
  int seen[3] = {0, 0, 0};
  for (int trial = 0; trial < 1500; ++trial) {
    const Vec3 center = DrawPoint(&rng, 3.5);
    const Vec3 half = DrawPoint(&rng, 1.0).cwiseAbs() * (trial % 3 == 0 ? 0.6 : 0.1);
    const core::Box3 box{center - half, center + half};
    const CellState state = StateOfBox(this->tree_, box);
    ++seen[static_cast<int>(state)];
    EXPECT_EQ(state, BruteState(this->tree_, this->tree_.KeyAt(box.min), this->tree_.KeyAt(box.max),
                                [](const NodeKey&) { return true; }))
        << trial;
  }
  for (const int count : seen) EXPECT_GT(count, 20);
}

double DistanceToSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  double lo = 0.0, hi = 1.0;  // convex along the segment: thirds
  for (int i = 0; i < 40; ++i) {
    const double s = lo + (hi - lo) / 3.0, t = hi - (hi - lo) / 3.0;
    (((p - a - s * (b - a)).norm() < (p - a - t * (b - a)).norm()) ? hi : lo) =
        (p - a - s * (b - a)).norm() < (p - a - t * (b - a)).norm() ? t : s;
  }
  return (p - a - lo * (b - a)).norm();
}

TYPED_TEST(QueriesOf, StateOfASweptSphereIsThatOfTheVoxelsNearItsPath) {
  core::Rng rng(15);
  int seen[3] = {0, 0, 0};
  for (int trial = 0; trial < 250; ++trial) {
    std::vector<Vec3> path = {DrawPoint(&rng, 3.0)};
    for (int leg = rng.UniformInt(3); leg > 0; --leg) path.push_back(path.back() + DrawPoint(&rng, 0.2));
    const double radius_m = rng.Uniform(0.02, 0.12);
    const auto state_within = [&](double reach_m) {
      core::Box3 around;
      for (const Vec3& p : path) around.Extend(p);
      around = around.Inflated(reach_m + kRes);
      return BruteState(
          this->tree_, this->tree_.KeyAt(around.min), this->tree_.KeyAt(around.max), [&](const NodeKey& key) {
            double distance = (this->tree_.CenterOf(key) - path[0]).norm();
            for (size_t i = 1; i < path.size(); ++i) {
              distance =
                  std::min(distance, DistanceToSegment(this->tree_.CenterOf(key), path[i - 1], path[i]));
            }
            return distance <= reach_m;
          });
    };
    const double reach_m = radius_m + 0.5 * std::sqrt(3.0) * kRes;
    const CellState state = StateOfSweptSphere<TypeParam>(this->tree_, path, radius_m);
    ++seen[static_cast<int>(state)];
    EXPECT_TRUE(state == state_within(reach_m - 1e-4) || state == state_within(reach_m + 1e-4)) << trial;
  }
  for (const int count : seen) EXPECT_GT(count, 2);
}

TYPED_TEST(QueriesOf, CellsCoverTheKnownVoxelsOnce) {
  VoxelMap<TypeParam> covered;
  int levels[4] = {0, 0, 0, 0};
  ForEachCell(this->tree_, [&](const NodeKey& key, int level, typename TypeParam::Value value) {
    ++levels[level];
    for (int i = 0; i < 1 << 3 * level; ++i) {
      const int mask = (1 << level) - 1;
      const NodeKey voxel{key.x << level | (i & mask), key.y << level | (i >> level & mask),
                          key.z << level | i >> 2 * level};
      EXPECT_TRUE(covered.emplace(voxel, value).second) << "visited twice";
    }
  });
  EXPECT_TRUE(covered == this->voxels_);
  EXPECT_TRUE(levels[0] > 0 && levels[1] > 0 && levels[3] > 0);
}

TEST(Queries, EmptyMapIsUnknownEverywhereInOneStepAChunk) {
  const OccupancyOctree tree(0.05);
  int segments = 0;
  TraceRay(tree, Vec3(0.1, 0.1, 0.1), Vec3::UnitX().eval(), 31.9, [&](const auto& segment) {
    EXPECT_EQ(segment.value, OccupancyField::Unknown());
    ++segments;
    return true;
  });
  EXPECT_EQ(segments, 10);
  EXPECT_EQ(StateOfBox(tree, core::Box3{Vec3(-50, -50, -5), Vec3(50, 50, 5)}), CellState::kUnknown);
  EXPECT_FALSE(FirstOccupied(tree, Vec3::Zero(), Vec3::UnitX(), 100.0).has_value());
}

}  // namespace
}  // namespace atlas::mapping
