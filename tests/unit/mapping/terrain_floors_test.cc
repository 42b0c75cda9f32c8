// Floors as images and cells, without sensors: which are joined, and what is remembered of which.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mapping/terrain/traversability.h"

namespace atlas::mapping::terrain {
namespace {

constexpr int kSide = 120;
constexpr int kFoot = 30;  ///< column at which the ramp begins
constexpr float kUpperFloor_m = 0.6f;

/// Ground without gaps whose height depends on the column; all of it was seen, nothing stands on it.
template <typename HeightAt>
GroundImage GroundOf(const HeightAt& height_at) {
  GroundImage image;
  image.side = kSide;
  const auto count = static_cast<size_t>(kSide) * kSide;
  image.kind.assign(count, CellKind::kGround);
  image.support.assign(count, 10);
  image.crossings.assign(count, 0);
  image.blocked.assign(count, 0);
  image.headroom.assign(count, 1);
  for (int row = 0; row < kSide; ++row) {
    for (int col = 0; col < kSide; ++col) image.height_m.push_back(height_at(col));
  }
  image.reference_m = image.height_m;
  return image;
}

/// A lower floor, and a level that holds the same ground up to the ramp's foot, then the ramp and the floor
/// that it leads to. Whether that floor's middle is free.
bool UpperFloorIsReachedOver(int ramp_columns) {
  const GroundImage lower = GroundOf([](int) { return 0.0f; });
  const GroundImage upper = GroundOf([&](int col) {
    const float up = static_cast<float>(col - kFoot) / static_cast<float>(ramp_columns);
    return kUpperFloor_m * std::clamp(up, 0.0f, 1.0f);
  });
  const std::vector<TerrainImage> levels =
      AssessLevels(TerrainParams{}, {lower, upper}, kSide / 2, kFoot / 2, 15);
  const size_t middle = levels[1].Index(kSide / 2, kFoot + ramp_columns + 15);
  EXPECT_EQ(levels[0].kind[middle], GroundKind::kFree) << "beneath it";
  EXPECT_TRUE(levels[1].kind[middle] == GroundKind::kFree || levels[1].kind[middle] == GroundKind::kCutOff);
  return levels[1].kind[middle] == GroundKind::kFree;
}

TEST(TerrainFloors, AnUpperFloorIsReachedByARampThatCanBeWalkedAndByNoOther) {
  EXPECT_TRUE(UpperFloorIsReachedOver(60)) << "0.6 m in 2.4 m";
  EXPECT_FALSE(UpperFloorIsReachedOver(12)) << "0.6 m in 0.48 m";
}

TEST(TerrainFloors, RaysThatCrossedOneFloorAreForgottenOnAnother) {
  LayeredGrid grid(0.04, 80);
  grid.CenterOn(0, 0);
  GroundImage where;
  where.min_x = where.min_y = -30;
  where.side = 60;
  for (int iy = -40; iy < 40; ++iy) {
    for (int ix = -40; ix < 40; ++ix) {
      for (const float floor_m : {0.0f, 3.0f}) grid.AddHeight(grid.Slot(ix, iy), floor_m, 1e-4f, 5);
    }
  }
  const size_t slot = grid.Slot(10, 10);
  const auto stand_on = [&](float ground_m) {
    FindLevels({}, {.robot = {0.0, 0.0}, .seed_radius_m = 0.3, .ground_m = ground_m}, where, &grid);
    EXPECT_NEAR(grid.reference_m(slot), ground_m, 0.01f);
  };
  stand_on(3.0f);
  for (int ray = 0; ray < 5; ++ray) grid.AddCrossing(slot);
  stand_on(3.0f);
  EXPECT_EQ(grid.crossings(slot), 5) << "the same floor";
  stand_on(0.0f);
  EXPECT_EQ(grid.crossings(slot), 0) << "they crossed the floor above";
}

constexpr int kGridSide = 160;

/// Levels about a robot at the middle of an empty floor, on which something stands whose top, `top(x, y)` in
/// metres, was seen, NaN beside it. The floor beneath it was seen too but for `x` below -1.6 m.
template <typename Top>
std::vector<GroundImage> LevelsWith(const Top& top) {
  LayeredGrid grid(0.04, kGridSide + 40);
  grid.CenterOn(0, 0);
  GroundImage where;
  where.min_x = where.min_y = -kGridSide / 2;
  where.side = kGridSide;
  for (int iy = -kGridSide / 2; iy < kGridSide / 2; ++iy) {
    for (int ix = -kGridSide / 2; ix < kGridSide / 2; ++ix) {
      const float x = 0.04f * (static_cast<float>(ix) + 0.5f), y = 0.04f * (static_cast<float>(iy) + 0.5f);
      const float above_m = top(x, y);
      const bool stands = !std::isnan(above_m);
      if (!stands || x > -1.6f) grid.AddHeight(grid.Slot(ix, iy), 0.0f, 1e-4f, 5);
      if (stands) grid.AddHeight(grid.Slot(ix, iy), above_m, 1e-4f, 5);
    }
  }
  return FindLevels({}, {.robot = {0.0, 0.0}, .seed_radius_m = 0.3, .ground_m = 0.0f}, where, &grid);
}

TEST(TerrainFloors, AHullIsNoFloorThoughItIsFlatOnTop) {
  // Sides of 70 degrees up to 1.4 m, where it is half a metre wide.
  const auto hull = [](float x, float y) {
    const float inside = 0.75f - std::abs(y - 2.0f);
    return std::abs(x) < 2.4f && inside > 0.0f ? std::min(0.1f + 2.75f * inside, 1.4f) : NAN;
  };
  const std::vector<GroundImage> levels = LevelsWith(hull);
  EXPECT_EQ(levels.size(), 1u);
  const size_t beneath = levels[0].Index(kGridSide / 2 + 50, kGridSide / 2);
  EXPECT_EQ(levels[0].kind[beneath], CellKind::kGround);
  EXPECT_NEAR(levels[0].height_m[beneath], 0.0f, 0.01f);
}

TEST(TerrainFloors, WhatARampLeadsToIsAFloor) {
  // 20 degrees, 1.4 m wide, from x = -3 m on to a platform at 1 m.
  const auto ramp = [](float x, float y) {
    return std::abs(y - 2.0f) < 0.7f && x > -3.0f ? std::min(0.364f * (x + 3.0f), 1.0f) : NAN;
  };
  const std::vector<GroundImage> levels = LevelsWith(ramp);
  ASSERT_EQ(levels.size(), 2u);
  const size_t platform = levels[0].Index(kGridSide / 2 + 50, kGridSide / 2 + 50);
  EXPECT_NEAR(levels[0].height_m[platform], 0.0f, 0.01f);
  EXPECT_EQ(levels[1].kind[platform], CellKind::kGround);
  EXPECT_NEAR(levels[1].height_m[platform], 1.0f, 0.01f);
}

}  // namespace
}  // namespace atlas::mapping::terrain
