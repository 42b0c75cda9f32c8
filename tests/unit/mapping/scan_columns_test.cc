// Images filled only where what is kept lies.
#include <gtest/gtest.h>

#include "mapping/integrator/projection/grid_columns.h"
#include "tests/support/integrator_scenes.h"

namespace atlas::mapping {
namespace {

using core::Vec3;
using Field = OccupancyField;

class ScanColumns : public ::testing::Test {
 protected:
  size_t Filled() const {
    size_t filled = 0;
    for (const GridColumns::Run& run : image_.runs) filled += run.last - run.first;
    return filled;
  }
  /// The column that a point falls into, by plain arithmetic.
  int ColumnOf(const core::Pose& T_map_lidar, const Vec3& p_map) const {
    const Vec3 p = T_map_lidar.inverse() * p_map;
    const double turn = (std::atan2(p.y(), p.x()) - grid_.phase_rad) / grid_.column_pitch_rad;
    const int column = static_cast<int>(std::floor(turn));
    return ((column % grid_.columns) + grid_.columns) % grid_.columns;
  }

  const core::LidarModel lidar_ = core::FindLidarModel("os1_64");
  const BeamGrid grid_ = MakeBeamGrid(lidar_);
  GridColumns image_{grid_};
};

TEST_F(ScanColumns, EveryPointOfTheBoxIsSeenWithAWindowAround) {
  core::Rng rng(3);
  int narrowed = 0, split = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 low(rng.Uniform(-6, 6), rng.Uniform(-6, 6), rng.Uniform(-2, 2));
    const core::Box3 box{low, low + Vec3(rng.Uniform(0.2, 6), rng.Uniform(0.2, 6), rng.Uniform(0.2, 3))};
    const core::Pose at = core::MakePose(
        core::RotationFromYawPitchRoll(rng.Uniform(-4, 4), rng.Uniform(-0.3, 0.3), rng.Uniform(-0.3, 0.3)),
        {rng.Uniform(-9, 9), rng.Uniform(-9, 9), rng.Uniform(-1, 1)});
    KeepColumns(box, at, &image_);
    if (Filled() < static_cast<size_t>(grid_.columns)) ++narrowed;
    if (image_.runs.size() > 1) ++split;
    for (int k = 0; k < 200; ++k) {
      const Vec3 share(rng.Uniform(0, 1), rng.Uniform(0, 1), rng.Uniform(0, 1));
      const Vec3 p = box.min + share.cwiseProduct(box.max - box.min);
      const int column = ColumnOf(at, p);
      for (const int aside : {-GridColumns::kWindowReach, 0, GridColumns::kWindowReach}) {
        const int c = (column + aside + grid_.columns) % grid_.columns;
        ASSERT_TRUE(image_.Filled(static_cast<size_t>(c))) << "scene " << i << ", column " << c;
      }
    }
  }
  EXPECT_GT(narrowed, 100);
  EXPECT_GT(split, 10);
}

TEST_F(ScanColumns, AFarBoxTakesFewColumnsAndOneAroundTheAxisAll) {
  const core::Pose at = core::Pose::Identity();
  KeepColumns(core::Box3{{9, -1, -1}, {11, 1, 1}}, at, &image_);
  EXPECT_LT(Filled(), static_cast<size_t>(grid_.columns) / 3);
  KeepColumns(core::Box3{{-1, -1, 2}, {1, 1, 3}}, at, &image_);  // overhead
  EXPECT_EQ(Filled(), static_cast<size_t>(grid_.columns));
  KeepColumns(std::nullopt, at, &image_);
  EXPECT_EQ(Filled(), static_cast<size_t>(grid_.columns));
}

TEST(ScanColumnsOfMaps, WhatIsKeptIsAsInAMapOfEverything) {
  const core::Box3 region{{-1.3, -1.2, -0.2}, {1.1, 1.4, 1.6}};
  tests::AnalyticWorld world;
  world.AddPlane({0, 0, 1}, -0.013);
  world.AddPlane({1, 0, 0}, 9.021);
  world.AddBox({{-0.52, -0.43, -0.02}, {0.51, 0.37, 0.83}});
  world.AddPillar(0.7, 0.9, 0.05, -0.02, 1.4);
  const core::LidarModel lidar = tests::SmallLidar(32, 512);
  const auto integrate = [&](const std::optional<core::Box3>& keep) {
    IntegratorParams params;
    params.region_map = keep;
    OccupancyOctree map(0.07);
    const auto integrator = MakeConeIntegrator<Field>(params, lidar);
    for (int k = 0; k < 12; ++k) {  // around it, so that what one scan leaves behind is old in the next
      const double turn = core::kPi * k / 6.0;
      const core::Pose at = core::MakePose(core::RotationFromYawPitchRoll(2.0 * turn + 0.3, 0.02, -0.03),
                                           {4.5 * std::cos(turn), 4.5 * std::sin(turn), 0.9});
      const core::SpinEvent spin = tests::SpinThrough(world, lidar, 0.1 * k, tests::StandingAt(at));
      integrator->Integrate(spin, core::Pose::Identity(), &map);
    }
    return map;
  };
  const OccupancyOctree all = integrate(std::nullopt), kept = integrate(region);
  size_t known = 0, different = 0;
  for (double z = region.min.z() + 0.01; z < region.max.z(); z += 0.07) {
    for (double y = region.min.y() + 0.01; y < region.max.y(); y += 0.07) {
      for (double x = region.min.x() + 0.01; x < region.max.x(); x += 0.07) {
        const int a = all.At(Vec3(x, y, z)), b = kept.At(Vec3(x, y, z));
        known += Field::Known(all.At(Vec3(x, y, z))) ? 1 : 0;
        different += (a > 0) != (b > 0) || (a < 0) != (b < 0) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(known, 20000u);
  // Which of many hits in a voxel are followed depends on those that are taken with them.
  EXPECT_LE(different, known / 2000);
}

}  // namespace
}  // namespace atlas::mapping
