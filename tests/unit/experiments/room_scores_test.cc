// Whether submaps tell rooms apart, by hand-counted cases and by counting pairs.
#include "experiments/judge/room_scores.h"

#include <gtest/gtest.h>

#include "core/rng.h"
#include "scenes/catalog.h"

namespace atlas::experiments {
namespace {

TEST(RoomScores, OneSubmapARoomIsPerfect) {
  const RoomScores s = ScorePartition({4, 4, 9, 9, 9, 2}, {0, 0, 1, 1, 1, 2});
  EXPECT_DOUBLE_EQ(s.precision, 1.0);
  EXPECT_DOUBLE_EQ(s.recall, 1.0);
  EXPECT_DOUBLE_EQ(s.adjusted_rand, 1.0);
  EXPECT_EQ(s.rooms, 3u);
  EXPECT_EQ(s.rooms_shared, 0u);
}

TEST(RoomScores, ASubmapOfTwoRoomsCostsPrecisionAndIsShared) {
  // Submap 0 holds rooms 0 (3 of 3) and 1 (1 of 2); submap 1 holds the rest of room 1.
  const RoomScores s = ScorePartition({0, 0, 0, 0, 1}, {0, 0, 0, 1, 1});
  EXPECT_DOUBLE_EQ(s.precision, 0.5 * (0.75 + 1.0));
  EXPECT_DOUBLE_EQ(s.recall, 0.5 * (1.0 + 0.5));
  EXPECT_EQ(s.rooms_shared, 2u);  // of room 1 the tie goes to submap 0
}

TEST(RoomScores, ARoomOfTwoSubmapsCostsRecall) {
  const RoomScores s = ScorePartition({0, 0, 1, 2}, {0, 0, 0, 1});
  EXPECT_DOUBLE_EQ(s.precision, 1.0);
  EXPECT_DOUBLE_EQ(s.recall, 0.5 * (2.0 / 3.0 + 1.0));
  EXPECT_EQ(s.rooms_shared, 0u);
}

/// Hubert and Arabie's index from the pairs themselves.
double RandByPairs(const std::vector<int>& a, const std::vector<int>& b) {
  double both = 0, in_a = 0, in_b = 0, all = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    for (size_t j = i + 1; j < a.size(); ++j) {
      const bool same_a = a[i] == a[j], same_b = b[i] == b[j];
      all += 1;
      in_a += same_a;
      in_b += same_b;
      both += same_a && same_b;
    }
  }
  const double chance = in_a * in_b / all;
  return (both - chance) / (0.5 * (in_a + in_b) - chance);
}

TEST(RoomScores, AdjustedRandEqualsThatOfAllPairs) {
  core::Rng rng(5);
  for (int round = 0; round < 20; ++round) {
    std::vector<int> submap, room;
    for (int i = 0; i < 40; ++i) {
      room.push_back(static_cast<int>(rng.UniformInt(5)));
      submap.push_back(rng.UniformInt(3) == 0 ? static_cast<int>(rng.UniformInt(7)) : room.back());
    }
    EXPECT_NEAR(ScorePartition(submap, room).adjusted_rand, RandByPairs(submap, room), 1e-12);
  }
}

TEST(RoomScores, CountKeyframesThatASubmapHoldsAndThatLieInARoom) {
  scenes::SceneSpec scene;
  scene.rooms = {{"a", {core::Vec3(0, 0, 0), core::Vec3(4, 4, 3)}},
                 {"b", {core::Vec3(4, 0, 0), core::Vec3(8, 4, 3)}},
                 {"a", {core::Vec3(0, 4, 0), core::Vec3(4, 8, 3)}}};
  std::vector<PlaceErrors::Place> places(5);
  const core::Vec3 at[] = {{1, 1, 0.5}, {1, 6, 0.5}, {5, 1, 0.5}, {20, 1, 0.5}, {6, 2, 0.5}};
  for (core::KeyframeId k = 0; k < 5; ++k) {
    places[k].base.keyframe = k;
    places[k].T_map_base_true = core::PoseFromXyzYaw(at[k], 0.0);
  }
  EXPECT_FALSE(ScoreRooms(scene, places, {}).has_value());
  // Keyframe 3 lies in no room, keyframe 4 in no submap.
  const auto s = ScoreRooms(scene, places, {{0, {0, 1}}, {1, {2, 3}}});
  ASSERT_TRUE(s.has_value());
  EXPECT_EQ(s->rooms, 2u);
  EXPECT_DOUBLE_EQ(s->precision, 1.0);
  EXPECT_DOUBLE_EQ(s->recall, 1.0);
}

TEST(RoomScores, ShippedRoomsCoverTheirFloorsOnce) {
  for (const char* name : {"rooms_small", "rooms_large", "lab_three_storeys"}) {
    SCOPED_TRACE(name);
    const scenes::SceneSpec scene = scenes::LoadScene(name);
    ASSERT_FALSE(scene.rooms.empty());
    EXPECT_TRUE(RoomAt(scene, scene.T_map_spawn * core::Vec3(0, 0, 0.5)).has_value());
    core::Box3 all;
    for (const scenes::Room& room : scene.rooms) {
      all.Extend(room.box.min);
      all.Extend(room.box.max);
    }
    core::Rng rng(3);
    for (int i = 0; i < 2000; ++i) {
      const core::Vec3 p(rng.Uniform(all.min.x(), all.max.x()), rng.Uniform(all.min.y(), all.max.y()),
                         rng.Uniform(all.min.z(), all.max.z()));
      int holders = 0;
      for (const scenes::Room& room : scene.rooms) holders += room.box.Contains(p);
      EXPECT_EQ(holders, 1) << p.transpose();
    }
  }
}

}  // namespace
}  // namespace atlas::experiments
