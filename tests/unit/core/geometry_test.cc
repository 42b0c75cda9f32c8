#include "core/geometry.h"

#include <gtest/gtest.h>

#include "core/lidar_model.h"
#include "core/rng.h"

namespace atlas::core {
namespace {

TEST(Geometry, TurnsYawThenPitchThenRollEachAboutTheAxisThatTheLastLeft) {
  // x forward, y left, z up: the bow of a body that yaws by 90 degrees and pitches by 30 points left and
  // down.
  const Mat3 R = RotationFromYawPitchRoll(kPi / 2, Radians(30.0), Radians(20.0));
  const double c30 = std::sqrt(0.75), s30 = 0.5, c20 = std::cos(Radians(20.0)), s20 = std::sin(Radians(20.0));
  EXPECT_LT((R * Vec3::UnitX() - Vec3(0.0, c30, -s30)).norm(), 1e-12);
  // Its left side looked to -x, and rolls up: z of the rolled body is (0, s30, c30).
  EXPECT_LT((R * Vec3::UnitY() - (c20 * Vec3(-1.0, 0.0, 0.0) + s20 * Vec3(0.0, s30, c30))).norm(), 1e-12);
  EXPECT_NEAR(YawOf(R), kPi / 2, 1e-12);
}

TEST(Geometry, AnglesWrapToHalfATurnEitherWay) {
  EXPECT_NEAR(WrapAngle(Radians(190.0)), Radians(-170.0), 1e-12);
  EXPECT_NEAR(WrapAngle(Radians(-190.0)), Radians(170.0), 1e-12);
  EXPECT_NEAR(WrapAngle(Radians(100.0)), Radians(100.0), 1e-12);
  EXPECT_NEAR(WrapAngle(Radians(730.0)), Radians(10.0), 1e-12);
}

TEST(Geometry, PosesAreInterpolatedFromTheFirstToTheSecond) {
  const Pose a = PoseFromXyzYaw({1, 2, 3}, 0.2), b = PoseFromXyzYaw({5, 2, 1}, 1.0);
  EXPECT_LT((Interpolate(a, b, 0.0).matrix() - a.matrix()).norm(), 1e-12);
  EXPECT_LT((Interpolate(a, b, 1.0).matrix() - b.matrix()).norm(), 1e-12);
  EXPECT_LT((Interpolate(a, b, 0.25).translation() - Vec3(2, 2, 2.5)).norm(), 1e-12);
  EXPECT_NEAR(YawOf(Interpolate(a, b, 0.25).linear()), 0.4, 1e-12);
}

TEST(RngStreams, DependOnTheSeedAndOnTheName) {
  EXPECT_NE(Rng(1).Split("a").Next(), Rng(2).Split("a").Next());
  EXPECT_NE(Rng(1).Split("a").Next(), Rng(1).Split("b").Next());
  EXPECT_NE(Rng(1).Next(), Rng(2).Next());
  Rng parent(5);
  parent.Split("a");
  EXPECT_EQ(parent.Next(), Rng(5).Next()) << "a child leaves its parent alone";
}

TEST(LidarModel, ColumnsTurnClockwiseAndRowsLookDownwards) {
  for (const std::string& name : LidarModelNames()) {
    const LidarModel model = FindLidarModel(name);
    const Vec3 first = model.Direction(0, 0), quarter = model.Direction(0, model.columns / 4);
    EXPECT_GT(first.head<2>().normalized().dot(Vec2(1, 0)), 0.99) << name;
    EXPECT_GT(quarter.head<2>().normalized().dot(Vec2(0, -1)), 0.99) << name;
    EXPECT_GT(first.z(), 0.0) << name;
    EXPECT_LT(model.Direction(model.rows() - 1, 0).z(), 0.0) << name;
  }
}

}  // namespace
}  // namespace atlas::core
