#include "mapping/slam/places.h"

#include <gtest/gtest.h>

#include <set>

#include "core/rng.h"
#include "core/stopwatch.h"

namespace atlas::tests {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;
using core::Vec3f;
using mapping::DescribePlace;
using mapping::PlaceCandidate;
using mapping::PlaceDatabase;
using mapping::PlaceQueryParams;

/// A wall on the plan.
struct Wall {
  Vec2 from, to;
};

/// Walls drawn at random about the origin, the same for a seed.
std::vector<Wall> Plan(uint64_t seed) {
  core::Rng rng(seed);
  std::vector<Wall> walls;
  for (int i = 0; i < 14; ++i) {
    const Vec2 from(rng.Uniform(-14.0, 14.0), rng.Uniform(-14.0, 14.0));
    const double length = rng.Uniform(2.0, 9.0), angle = 0.5 * core::kPi * rng.UniformInt(2) + 0.2;
    walls.push_back({from, from + length * Vec2(std::cos(angle), std::sin(angle))});
  }
  return walls;
}

/// Points on walls 2.5 m high, a floor and a ceiling, seen from a level frame.
std::vector<Vec3f> SeenFrom(const std::vector<Wall>& walls, const Pose& T_world_here, uint64_t seed) {
  core::Rng rng(seed);
  std::vector<Vec3f> points;
  const Pose T = T_world_here.inverse();
  for (const Wall& wall : walls) {
    const int count = static_cast<int>(120.0 * (wall.to - wall.from).norm());
    for (int i = 0; i < count; ++i) {
      const Vec2 p = wall.from + rng.Uniform() * (wall.to - wall.from);
      points.push_back((T * Vec3(p.x(), p.y(), rng.Uniform(0.0, 2.5))).cast<float>());
    }
  }
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(rng.Uniform(-15.0, 15.0), rng.Uniform(-15.0, 15.0), 2.5 * rng.UniformInt(2));
    points.push_back((T * p).cast<float>());
  }
  return points;
}

Pose Level(double x, double y, double yaw_rad) {
  return core::PoseFromXyzYaw(Vec3(x, y, 1.0), yaw_rad);
}

TEST(Places, ATurnedAndShiftedPlaceIsFoundWithItsPose) {
  PlaceDatabase database;
  for (uint32_t id = 0; id < 20; ++id)
    database.Add(100 + id, DescribePlace(SeenFrom(Plan(id), Level(0, 0, 0), 50)));
  core::Rng rng(1);
  for (uint32_t id = 0; id < 20; ++id) {
    const Pose T = Level(rng.Uniform(-3.0, 3.0), rng.Uniform(-3.0, 3.0), rng.Uniform(-core::kPi, core::kPi));
    const auto found = database.Query(DescribePlace(SeenFrom(Plan(id), T, 60)), {});
    ASSERT_FALSE(found.empty()) << id;
    EXPECT_EQ(found[0].id, 100 + id);
    EXPECT_NEAR(core::WrapAngle(found[0].yaw_rad - core::YawOf(T.linear())), 0.0, core::Radians(3.0)) << id;
    EXPECT_LT((found[0].T_candidate_query.translation() - T.translation()).head<2>().norm(), 0.8) << id;
    for (const PlaceCandidate& other : found) {
      EXPECT_TRUE(other.id == found[0].id || other.distance > found[0].distance + 0.1) << id;
    }
  }
}

TEST(Places, ARoomOfHalfTurnSymmetryYieldsBothWays) {
  const std::vector<Wall> room = {{{-4, -2.5}, {4, -2.5}}, {{4, -2.5}, {4, 2.5}}, {{4, 2.5}, {-4, 2.5}},
                                  {{-4, 2.5}, {-4, -2.5}}, {{-4, 1}, {-2, 1}},    {{4, -1}, {2, -1}}};
  PlaceDatabase database;
  database.Add(7, DescribePlace(SeenFrom(room, Level(0, 0, 0), 1)));
  const double yaw = 0.6;
  const auto found = database.Query(DescribePlace(SeenFrom(room, Level(1.0, -0.4, yaw), 2)), {});
  ASSERT_EQ(found.size(), 2u);
  EXPECT_LT(found[1].distance - found[0].distance, 0.1);
  EXPECT_NEAR(std::abs(core::WrapAngle(found[0].yaw_rad - found[1].yaw_rad)), core::kPi, 1e-6);
  for (const PlaceCandidate& way : found) {
    const bool as_is = std::abs(core::WrapAngle(way.yaw_rad - yaw)) < 0.5;
    const Vec2 expected = as_is ? Vec2(1.0, -0.4) : Vec2(-1.0, 0.4);
    EXPECT_LT((way.T_candidate_query.translation().head<2>() - expected).norm(), 0.8);
  }
}

TEST(Places, OnlyTheYoungestAreSkipped) {
  PlaceDatabase database;
  for (uint32_t id = 0; id < 6; ++id)
    database.Add(id, DescribePlace(SeenFrom(Plan(3), Level(0.1 * id, 0, 0), id)));
  PlaceQueryParams params;
  params.skip_youngest = 4;
  std::set<uint32_t> ids;
  const auto query = DescribePlace(SeenFrom(Plan(3), Level(0.3, 0, 0), 9));
  for (const PlaceCandidate& found : database.Query(query, params)) ids.insert(found.id);
  EXPECT_EQ(ids, (std::set<uint32_t>{0, 1}));
  params.skip_youngest = 9;
  EXPECT_TRUE(database.Query(query, params).empty());
}

TEST(Places, FloorAndCeilingAreNoPlace) {
  const auto bare = DescribePlace(SeenFrom({}, Level(0, 0, 0), 4));
  EXPECT_TRUE(bare.cells.empty());
  PlaceDatabase database;
  database.Add(0, bare);
  database.Add(1, DescribePlace({}));
  EXPECT_TRUE(database.Query(bare, {}).empty());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(DescribePlace(std::vector<Vec3f>{{nan, 0, 0}, {1e9f, 0, 0}, {0, 0, nan}}).cells.empty());
}

TEST(Places, AThousandKeyframesTakeMilliseconds) {
  PlaceDatabase database;
  std::vector<mapping::PlaceDescriptor> places;
  for (uint32_t id = 0; id < 40; ++id) places.push_back(DescribePlace(SeenFrom(Plan(id), Level(0, 0, 0), 5)));
  for (uint32_t id = 0; id < 1000; ++id) database.Add(id, places[id % 40]);
  double least_s = 1e9;  // of several: other processes take time too
  for (int k = 0; k < 10; ++k) {
    const core::Stopwatch watch;
    EXPECT_FALSE(database.Query(places[static_cast<size_t>(k)], {}).empty());
    least_s = std::min(least_s, watch.seconds());
  }
#ifdef NDEBUG
  EXPECT_LT(least_s, 0.05);  // 0.02 alone on the machine
#endif
}

}  // namespace
}  // namespace atlas::tests
