// What is read off the elevation map lies where the ground lies: between cells, across limits, in the map
// frame.
#include <gtest/gtest.h>

#include <cmath>

#include "mapping/terrain/posed_ground.h"
#include "mapping/terrain/traversability.h"
#include "tests/support/placed_spins.h"
#include "tests/unit/mapping/terrain_fixture.h"

namespace atlas::mapping {
namespace {

using core::PoseFromXyzYaw;
using core::Radians;
using core::Vec2;
using core::Vec3;
using tests::PatchWorld;
using tests::TerrainSensors;

TEST(TerrainReading, HeightsBetweenCentresRiseAsTheGroundDoes) {
  const Vec2 slope(0.12, 0.08);
  PatchWorld world;
  const Vec3 u = 60.0 * Vec3(1, 0, slope.x()).normalized();
  const Vec3 v = Vec3(-slope.x(), -slope.y(), 1).cross(u).normalized() * 60.0;
  world.patches.push_back({-0.5 * (u + v), u, v});
  TerrainSensors sensors(&world, 7);
  sensors.range_sigma_m = 0.0;
  ElevationMap map(TerrainParams{}, core::RobotExtent{});
  sensors.Sweep(PoseFromXyzYaw({0, 0, kStance}, 0.3), Radians(40), 30, &map);
  map.Update();

  const double cell = TerrainParams{}.cell_m, from = 0.2 * cell, to = 0.8 * cell;
  Vec2 rise = Vec2::Zero(), count = Vec2::Zero();
  for (int ix = -40; ix < 40; ++ix) {
    for (int iy = -40; iy < 40; ++iy) {
      const Vec2 centre((ix + 0.5) * cell, (iy + 0.5) * cell);
      if (centre.norm() < 0.6) continue;
      for (int axis = 0; axis < 2; ++axis) {
        const Vec2 along = Vec2::Unit(axis), a = centre + from * along, b = centre + to * along;
        const auto here = map.At(a.x(), a.y()), there = map.At(b.x(), b.y());
        if (!here.known || !there.known) continue;
        rise[axis] += (there.height_m - here.height_m) / (to - from);
        count[axis] += 1;
      }
    }
  }
  for (int axis = 0; axis < 2; ++axis) {
    ASSERT_GT(count[axis], 3000);
    EXPECT_NEAR(rise[axis] / count[axis], slope[axis], 0.1 * slope[axis]) << axis;
  }
}

constexpr int kSide = 120;

/// Ground of these heights, measured everywhere, by cell.
template <typename HeightAt>
terrain::GroundImage Measured(const HeightAt& height_at) {
  constexpr size_t kCells = static_cast<size_t>(kSide) * kSide;
  terrain::GroundImage ground;
  ground.side = kSide;
  ground.kind.assign(kCells, terrain::CellKind::kGround);
  ground.support.assign(kCells, 50);
  ground.crossings.assign(kCells, 0);
  ground.blocked.assign(kCells, 0);
  ground.headroom.assign(kCells, 1);
  ground.height_m.resize(kCells);
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) ground.height_m[ground.Index(r, c)] = static_cast<float>(height_at(r, c));
  }
  ground.reference_m = ground.height_m;
  return ground;
}

/// Limits that nothing exceeds, to set one at a time.
TerrainParams NoLimits() {
  TerrainParams params;
  params.critical_step_m = 100.0;
  params.critical_slope_deg = 89.0;
  params.critical_roughness_m = 100.0;
  params.min_traversability = 0.0;
  return params;
}

/// Share of the inner cells that may be walked on, of those that `counts`.
template <typename HeightAt, typename Counts>
double WalkableShare(const TerrainParams& params, const HeightAt& height_at, const Counts& counts) {
  const terrain::TerrainImage image =
      terrain::AssessTerrain(params, Measured(height_at), kSide / 2, kSide / 4, 20);
  double walkable = 0, all = 0;
  for (int r = 20; r < kSide - 20; ++r) {
    for (int c = 20; c < kSide - 20; ++c) {
      if (!counts(r, c)) continue;
      all += 1;
      walkable += image.traversability[image.Index(r, c)] > 0.0f;
    }
  }
  return walkable / all;
}

TEST(TerrainReading, StepsAreWalkedUpToTheCriticalHeightAndNotBeyond) {
  TerrainParams params = NoLimits();
  params.critical_step_m = 0.12;
  const auto share_with = [&](double step_m) {
    return WalkableShare(
        params, [=](int, int c) { return c < kSide / 2 ? 0.0 : step_m; },
        [](int, int c) { return c == kSide / 2 - 1 || c == kSide / 2; });
  };
  EXPECT_EQ(share_with(0.11), 1.0);
  EXPECT_EQ(share_with(0.13), 0.0);
}

TEST(TerrainReading, SlopesAreWalkedUpToTheCriticalAngleAndNotBeyond) {
  TerrainParams params = NoLimits();
  params.critical_slope_deg = 22.0;
  const auto share_with = [&](double slope_deg) {
    const double rise_m = params.cell_m * std::tan(Radians(slope_deg));
    return WalkableShare(
        params, [=](int r, int) { return r * rise_m; }, [](int, int) { return true; });
  };
  EXPECT_EQ(share_with(21.0), 1.0);
  EXPECT_EQ(share_with(23.0), 0.0);
}

TEST(TerrainReading, GroundIsWalkedUpToTheCriticalRoughnessAndNotBeyond) {
  TerrainParams params = NoLimits();
  params.critical_roughness_m = 0.06;
  const auto share_with = [&](double rms_m) {  // a chequerboard, of squares too wide for ridges
    return WalkableShare(
        params, [=](int r, int c) { return (r / 8 + c / 8) % 2 == 0 ? rms_m : -rms_m; },
        [](int, int) { return true; });
  };
  EXPECT_EQ(share_with(0.05), 1.0);
  EXPECT_LT(share_with(0.08), 0.3);
}

TEST(TerrainReading, TheDefaultStepIsOneThatAQuadrupedOfThisSizeClimbs) {
  EXPECT_LE(TerrainParams{}.critical_step_m, 0.35 * core::RobotExtent{}.stance_height_m);
}

TEST(TerrainReading, SpinsDepthImagesAndFeetLieWhereOdometryHasThem) {
  // A floor at the robot's soles, wherever odometry has drifted to.
  PatchWorld world;
  world.AddRectangle(-20, -20, 20, 20, 0.5);
  const core::Pose T_odom_base = PoseFromXyzYaw({3.0, 2.0, 0.5 + kStance}, 0.6);
  for (const std::string sensor : {"spin", "depth", "feet"}) {
    TerrainSensors sensors(&world, 4);
    ElevationMap map(TerrainParams{}, core::RobotExtent{});
    map.OnState(sensors.State(0.0, T_odom_base, sensor == "feet"));
    if (sensor == "spin") map.OnSpin(tests::Shared(sensors.Spin(0.0, [&](double) { return T_odom_base; })));
    if (sensor == "depth") map.OnDepth(sensors.Depth(T_odom_base, 0.4, Radians(30), 0));
    map.Update();
    int known = 0;
    for (double x = 0.3; x < 4.0; x += 0.02) {
      for (const double y : {-0.235, -0.1, 0.0, 0.1, 0.235}) {
        const Vec3 p_odom = T_odom_base * Vec3(x, y, 0.0);
        const auto ground = map.At(p_odom.x(), p_odom.y());
        if (!ground.known) continue;
        ++known;
        EXPECT_NEAR(ground.height_m, 0.5, 0.03) << sensor;
      }
    }
    EXPECT_GT(known, sensor == "feet" ? 1 : 20) << sensor;
    EXPECT_NEAR(map.Window().Center().x(), 3.0, 1e-9) << sensor;
    EXPECT_NEAR(map.Window().Center().y(), 2.0, 1e-9) << sensor;
  }
}

/// Ground on two levels, at 10 x + y and 4 m above: on the lower one obstacle at x < 1, a slope of so much as
/// y, and narrow along its x axis; on the upper one nothing.
class Marked final : public TraversableGround {
 public:
  static double HeightAt(const Vec2& p) { return 10.0 * p.x() + p.y(); }
  static bool IsLower(const Vec3& p) { return std::abs(p.z() - HeightAt(p.head<2>())) <= kSameLevel_m; }

  Levels LevelsAt(const Vec2& p) const override {
    Levels levels;
    levels.Add(HeightAt(p));
    levels.Add(HeightAt(p) + 4.0);
    return levels;
  }
  double Traversability(const Vec3& p) const override { return IsLower(p) ? p.x() : 0.0; }
  GroundKind KindAt(const Vec3& p) const override {
    if (!IsLower(p)) return GroundKind::kUnknown;
    return p.x() < 1.0 ? GroundKind::kObstacle : GroundKind::kFree;
  }
  bool FootprintFree(const Vec3& p, double yaw_rad) const override {
    return IsLower(p) && p.x() >= 1.0 && std::abs(core::WrapAngle(yaw_rad)) < 0.01;
  }
  bool CircleFree(const Vec3& p) const override { return IsLower(p) && p.y() > 2.0; }
  Surface SurfaceAt(const Vec3& p) const override { return {p.z(), p.y(), 0.25}; }
  core::Box3 Window() const override { return {Vec3(-3, -2, -4), Vec3(5, 6, 2.5)}; }
};

TEST(PosedGround, ShowsInTheMapWhatLiesInOdometry) {
  const Marked ground;
  const core::Pose T_map_odom = PoseFromXyzYaw({30.0, -7.0, 1.5}, 0.9);
  const core::Pose T_odom_base = PoseFromXyzYaw({1.0, 2.0, 0.4}, -0.3);
  const PosedGround posed(ground, T_map_odom * T_odom_base, T_odom_base);
  for (const Vec2& p : {Vec2(0.9, 2.5), Vec2(1.1, 1.5), Vec2(4.0, -3.0)}) {
    const Vec3 p_odom(p.x(), p.y(), Marked::HeightAt(p)), p_map = T_map_odom * p_odom;
    EXPECT_NEAR(posed.Traversability(p_map), p.x(), 1e-9);
    EXPECT_EQ(posed.KindAt(p_map), ground.KindAt(p_odom));
    EXPECT_EQ(posed.CircleFree(p_map), ground.CircleFree(p_odom));
    EXPECT_EQ(posed.FootprintFree(p_map, 0.9), p.x() >= 1.0);
    EXPECT_FALSE(posed.FootprintFree(p_map, 0.0));
    EXPECT_NEAR(posed.SurfaceAt(p_map).height_m, p_map.z(), 1e-9);
    EXPECT_NEAR(posed.SurfaceAt(p_map).slope_rad, p.y(), 1e-9);
    const auto levels = posed.LevelsAt(p_map.head<2>());
    ASSERT_EQ(levels.count, 2);
    EXPECT_NEAR(levels.height_m[0], p_map.z(), 1e-9);
    EXPECT_NEAR(levels.height_m[1], p_map.z() + 4.0, 1e-9);
    EXPECT_EQ(posed.KindAt(p_map - Vec3(0, 0, 1.5)), GroundKind::kUnknown) << "odometry's height";
  }
  const Vec3 centre = T_map_odom * Vec3(1.0, 2.0, -0.75);
  EXPECT_LT((posed.Window().Center() - centre).norm(), 1e-9);
  EXPECT_LT((posed.Window().Size() - Vec3(8, 8, 6.5)).norm(), 1e-9);
}

TEST(PosedGround, ATiltOfTheLocalisationLiftsNothing) {
  const Marked ground;
  const core::Pose T_odom_base = PoseFromXyzYaw({50.0, 2.0, 0.4}, 0.0);
  core::Pose T_map_base = T_odom_base;
  T_map_base.linear() = core::RotationFromYawPitchRoll(0.0, Radians(2.0), 0.0);
  const PosedGround posed(ground, T_map_base, T_odom_base);
  for (const double x : {50.0, 55.0}) {
    EXPECT_NEAR(posed.SurfaceAt({x, 2.0, 3.0}).height_m, 3.0, 1e-9) << x;
    EXPECT_NEAR(posed.LevelsAt({x, 2.0}).front(), ground.LevelsAt({x, 2.0}).front(), 1e-9) << x;
  }
}

}  // namespace
}  // namespace atlas::mapping
