// Window filters against brute force.
#include "mapping/terrain/grid_filters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/rng.h"

namespace atlas::mapping::terrain {
namespace {

constexpr int kRows = 37, kCols = 53;

size_t At(int r, int c) {
  return static_cast<size_t>(r * kCols + c);
}

Mask RandomMask(uint64_t seed, double share) {
  core::Rng rng(seed);
  Mask mask(static_cast<size_t>(kRows * kCols));
  for (auto& cell : mask) cell = rng.Uniform() < share;
  return mask;
}

TEST(TerrainFilters, DistanceEqualsBruteForceUpToTheRadius) {
  constexpr int kRadius = 9;
  for (const double share : {0.0, 0.003, 0.05, 0.6}) {
    const Mask mask = RandomMask(3, share);
    const std::vector<int16_t> distance2 = SquaredDistance(mask, kRows, kCols, kRadius);
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kCols; ++c) {
        int nearest = (kRadius + 1) * (kRadius + 1);
        for (int rr = 0; rr < kRows; ++rr) {
          for (int cc = 0; cc < kCols; ++cc) {
            const int d2 = (rr - r) * (rr - r) + (cc - c) * (cc - c);
            if (mask[At(rr, cc)] && d2 <= kRadius * kRadius) nearest = std::min(nearest, d2);
          }
        }
        if (nearest <= kRadius * kRadius) {
          ASSERT_EQ(distance2[At(r, c)], nearest) << r << "," << c;
        } else {
          ASSERT_GT(distance2[At(r, c)], kRadius * kRadius) << r << "," << c;
        }
      }
    }
  }
}

TEST(TerrainFilters, RidgesStandAboveEverySquareThatFitsUnderThem) {
  // An opening is the highest floor of all the squares that hold the cell.
  core::Rng rng(6);
  const Mask valid = RandomMask(8, 0.9);
  std::vector<float> value(valid.size());
  for (float& v : value) v = static_cast<float>(rng.Normal());
  constexpr int kRadius = 2;
  const std::vector<float> ridge = Ridges(value, valid, kRows, kCols, kRadius);
  const auto floor_of = [&](int r, int c) {
    float low = 1e9f;
    for (int rr = std::max(0, r - kRadius); rr <= std::min(kRows - 1, r + kRadius); ++rr) {
      for (int cc = std::max(0, c - kRadius); cc <= std::min(kCols - 1, c + kRadius); ++cc) {
        if (valid[At(rr, cc)]) low = std::min(low, value[At(rr, cc)]);
      }
    }
    return low;
  };
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      float opened = -1e9f;
      for (int rr = std::max(0, r - kRadius); rr <= std::min(kRows - 1, r + kRadius); ++rr) {
        for (int cc = std::max(0, c - kRadius); cc <= std::min(kCols - 1, c + kRadius); ++cc) {
          opened = std::max(opened, floor_of(rr, cc));
        }
      }
      const float expected = valid[At(r, c)] ? std::max(0.0f, value[At(r, c)] - opened) : 0.0f;
      ASSERT_FLOAT_EQ(ridge[At(r, c)], expected) << r << "," << c;
    }
  }
}

TEST(TerrainFilters, SlidingRangeEqualsBruteForce) {
  core::Rng rng(5);
  const Mask valid = RandomMask(4, 0.7);
  std::vector<float> value(valid.size());
  for (float& v : value) v = static_cast<float>(rng.Normal());
  const std::vector<float> range = SlidingRange(value, valid, kRows, kCols, 2);
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      float low = 1e9f, high = -1e9f;
      for (int rr = std::max(0, r - 2); rr <= std::min(kRows - 1, r + 2); ++rr) {
        for (int cc = std::max(0, c - 2); cc <= std::min(kCols - 1, c + 2); ++cc) {
          if (!valid[At(rr, cc)]) continue;
          low = std::min(low, value[At(rr, cc)]);
          high = std::max(high, value[At(rr, cc)]);
        }
      }
      ASSERT_FLOAT_EQ(range[At(r, c)], high >= low ? high - low : 0.0f);
    }
  }
}

TEST(TerrainFilters, PlaneFitRecoversAnInclinedPlaneThroughMissingCells) {
  const Mask valid = RandomMask(6, 0.6);
  std::vector<float> height(valid.size());
  const double a = 0.2, b = -0.1, cell = 0.04;
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kCols; ++c) {
      // A block's cells count at its centre, so the plane is laid in steps of blocks.
      height[At(r, c)] = static_cast<float>(7.0 + cell * (a * (2 * (c / 2) + 1) + b * (2 * (r / 2) + 1)));
    }
  }
  const PlaneFits fits = FitPlanes(height, valid, kRows, kCols, cell, 3);
  for (int r = 0; r < kRows / 2; ++r) {
    for (int c = 0; c < kCols / 2; ++c) {
      const size_t block = static_cast<size_t>(r * fits.cols + c);
      EXPECT_NEAR(fits.slope_rad[block], std::atan(std::hypot(a, b)), 2e-3);
      EXPECT_NEAR(fits.height_m[block], 7.0 + cell * (a * (2 * c + 1) + b * (2 * r + 1)), 1e-3);
      EXPECT_LT(fits.roughness_m[block], 1e-3);
    }
  }
}

TEST(TerrainFilters, PlaneFitReportsTheSpreadAboutThePlaneAsRoughness) {
  core::Rng rng(8);
  std::vector<float> height(static_cast<size_t>(kRows * kCols));
  for (float& h : height) h = static_cast<float>(0.03 * rng.Normal());
  const PlaneFits fits = FitPlanes(height, Mask(height.size(), 1), kRows, kCols, 0.04, 3);
  double sum = 0.0;
  for (const float roughness : fits.roughness_m) sum += static_cast<double>(roughness);
  EXPECT_NEAR(sum / static_cast<double>(fits.roughness_m.size()), 0.03, 0.002);
}

}  // namespace
}  // namespace atlas::mapping::terrain
