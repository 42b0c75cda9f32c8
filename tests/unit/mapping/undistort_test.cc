#include "mapping/cloud/undistort.h"

#include <gtest/gtest.h>

namespace atlas::mapping {
namespace {

/// A row of ten columns whose returns have these ranges; 0: none.
core::SpinEvent RowOf(const std::vector<float>& range_m) {
  core::SpinEvent spin;
  spin.scan.rows = 1;
  spin.scan.columns = static_cast<int>(range_m.size());
  for (size_t i = 0; i < range_m.size(); ++i) {
    const double azimuth = -2.0 * core::kPi * static_cast<double>(i) / static_cast<double>(range_m.size());
    spin.scan.direction_lidar.push_back(core::Vec3(std::cos(azimuth), std::sin(azimuth), 0.0).cast<float>());
    spin.scan.range_m.push_back(range_m[i]);
    spin.scan.time_s.push_back(0.01f * static_cast<float>(i));
    spin.scan.kind.push_back(range_m[i] > 0.0f ? core::ReturnKind::kHit : core::ReturnKind::kVoid);
  }
  spin.T_odom_lidar.Add(0.0, core::Pose::Identity());
  return spin;
}

std::vector<float> RangesKept(const std::vector<float>& range_m) {
  UndistortedSpin out;
  Undistort(RowOf(range_m), core::Pose::Identity(), &out);
  std::vector<float> kept;
  for (const MapRay& ray : out.hits) kept.push_back(ray.range_m);
  return kept;
}

TEST(Undistort, ReturnsThatStandAloneAreLeftOut) {
  // Dust at 2 m before a wall, a return amid none, and a pair two columns apart.
  EXPECT_EQ(RangesKept({5, 5, 2, 5, 5, 5, 5, 5, 5, 5}).size(), 9u);
  EXPECT_TRUE(RangesKept({0, 0, 0, 0, 3, 0, 0, 0, 0, 0}).empty());
  EXPECT_EQ(RangesKept({0, 0, 0, 3, 0, 3, 0, 0, 0, 0}).size(), 2u);
  EXPECT_EQ(RangesKept({4, 0, 0, 0, 0, 0, 0, 0, 0, 4}).size(), 2u) << "rows close on themselves";
}

TEST(Undistort, DropoutsAreNeitherHitsNorVoids) {
  core::SpinEvent spin = RowOf({5, 5, 5, 0, 0, 5, 5, 5, 5, 5});
  spin.scan.kind[3] = core::ReturnKind::kDropout;
  UndistortedSpin out;
  Undistort(spin, core::Pose::Identity(), &out);
  EXPECT_EQ(out.hits.size(), 8u);
  EXPECT_EQ(out.voids.size(), 1u);
}

}  // namespace
}  // namespace atlas::mapping
