// What one noise-free revolution says of a flat ground and of the space just above it.

#include <gtest/gtest.h>

#include <array>
#include <set>

#include "mapping/integrator/integrator.h"
#include "mapping/integrator/write/occupancy_shift.h"
#include "tests/support/shape_scans.h"

namespace atlas {
namespace {

using core::Vec3;
using Field = mapping::OccupancyField;

constexpr double kResolution = 0.065, kHeight_m = 1.0;

struct Ground {
  core::LidarModel lidar = core::FindLidarModel("os1_64");
  tests::HalfSpace shape;
  core::SpinEvent spin;
  mapping::OccupancyOctree map{kResolution};

  Ground(const Vec3& normal, double offset_m, const mapping::IntegratorParams& params = {})
      : shape(Vec3(0, 0, offset_m), normal) {
    core::Rng rng(1);
    const core::Pose T = core::MakePose(core::Mat3::Identity(), Vec3(0.01, 0.02, kHeight_m + offset_m));
    spin = tests::ScanShape(shape, lidar, T, 0.0, &rng);
    const auto integrator = mapping::MakeConeIntegrator<Field>(params, lidar);
    integrator->Integrate(spin, core::Pose::Identity(), &map);
  }
  /// Visits the rays that hit between two ranges, and where.
  template <typename Visit>
  void ForHits(double from_m, double to_m, const Visit& visit) const {
    const core::Pose& T = spin.T_odom_lidar.poses().front().T;
    for (size_t i = 0; i < spin.scan.size(); ++i) {
      const auto range = static_cast<double>(spin.scan.range_m[i]);
      if (spin.scan.kind[i] != core::ReturnKind::kHit || range < from_m || range > to_m) continue;
      const Vec3 direction = T.linear() * spin.scan.direction_lidar[i].cast<double>();
      visit(Vec3(T.translation()), direction, range);
    }
  }
};

TEST(IntegratedSurface, BeamsThatSkimItFreeWhatTheyPassBeforeIt) {
  for (const Vec3& normal : {Vec3(0, 0, 1), Vec3(0.05, -0.03, 1)}) {
    const Ground ground(normal, 0.02);
    const double support = mapping::OccupancyShift(normal.normalized(), kResolution);
    size_t free = 0, occupied = 0, all = 0;
    ground.ForHits(6.0, 15.0, [&](const Vec3& from, const Vec3& direction, double range) {
      for (double back = 0.1; back < 0.7; back += 0.1) {
        const Vec3 p = from + (range - back) * direction;
        const Vec3 middle = ground.map.CenterOf(ground.map.KeyAt(p));
        if (ground.shape.Distance(middle) < support + 0.3 * kResolution) continue;  // touched, or nearly
        const int8_t value = ground.map.At(p);
        free += Field::Free(value);
        occupied += Field::Occupied(value);
        ++all;
      }
    });
    ASSERT_GT(all, 10000u);
    EXPECT_GT(static_cast<double>(free), 0.998 * static_cast<double>(all));
    EXPECT_EQ(occupied, 0u);
  }
}

TEST(IntegratedSurface, VoxelsOfReturnsKnowTheirPlaceToAQuarter) {
  for (const double offset_m : {0.004, 0.02, 0.033, 0.047, 0.061}) {
    const Ground ground(Vec3(0, 0, 1), offset_m);
    size_t right = 0, near = 0, all = 0;
    ground.ForHits(2.0, 15.0, [&](const Vec3& from, const Vec3& direction, double range) {
      const int8_t value = ground.map.At(from + (range + 1e-4) * direction);
      if (!Field::Occupied(value)) return;
      const double error = std::abs(Field::PlaceOf(value) - offset_m / kResolution);
      right += error < 0.13;
      near += error < 0.38;
      ++all;
    });
    ASSERT_GT(all, 5000u);
    EXPECT_GT(static_cast<double>(right), 0.95 * static_cast<double>(all)) << offset_m;
    EXPECT_GT(static_cast<double>(near), 0.99 * static_cast<double>(all)) << offset_m;
  }
}

TEST(IntegratedSurface, BeamsThatSkimItTellOfTheirReturnsAloneWhereAsked) {
  // From 8 m on the ground is met at a cosine of 1 / 8 at most.
  for (const double skim_cosine : {0.0, 0.5}) {
    mapping::IntegratorParams params;
    params.skim_cosine = skim_cosine;
    const Ground ground(Vec3(0, 0, 1), 0.02, params);
    size_t returns = 0, hits = 0;
    std::set<std::array<int, 3>> told, with_returns;
    ground.ForHits(8.0, 12.0, [&](const Vec3& from, const Vec3& direction, double range) {
      ++hits;
      const Vec3 end = from + range * direction;
      returns += Field::Occupied(ground.map.At(end));
      const mapping::NodeKey home = ground.map.KeyAt(end);
      with_returns.insert({home.x, home.y, home.z});
      for (double off = -0.4; off < 0.4; off += 0.03) {
        const Vec3 p = end + off * Vec3(direction.x(), direction.y(), 0.0);
        const mapping::NodeKey key = ground.map.KeyAt(p);
        if (Field::Occupied(ground.map.At(p))) told.insert({key.x, key.y, key.z});
      }
    });
    ASSERT_GT(hits, 2000u);
    EXPECT_EQ(returns, hits);
    if (skim_cosine == 0.0) {
      EXPECT_GT(told.size(), 2 * hits);
    } else {
      EXPECT_TRUE(std::includes(with_returns.begin(), with_returns.end(), told.begin(), told.end()));
    }
  }
}

TEST(IntegratedSurface, WhatNoReturnFellIntoGainsLess) {
  mapping::IntegratorParams params;
  params.hit_nats = 1.2;
  params.near_nats = 0.4;
  const Ground ground(Vec3(0, 0, 1), 0.02, params);
  size_t hits = 0, below = 0;
  ground.ForHits(2.0, 15.0, [&](const Vec3& from, const Vec3& direction, double range) {
    const Vec3 p = from + (range + 1e-4) * direction;
    hits += Field::LogOdds(ground.map.At(p)) >= 1.2;
    const int8_t under = ground.map.At(p - Vec3(0, 0, kResolution));
    below += Field::Occupied(under);
    EXPECT_LT(Field::LogOdds(under), 0.4 + Field::kPlaces * Field::kNatsPerUnit);
  });
  EXPECT_GT(hits, 5000u);
  EXPECT_GT(below, 1000u);
}

}  // namespace
}  // namespace atlas
