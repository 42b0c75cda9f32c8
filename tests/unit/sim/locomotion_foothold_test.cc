#include <gtest/gtest.h>

#include "core/rng.h"
#include "locomotion_scenes.h"
#include "sim/locomotion/foothold.h"
#include "sim/locomotion/gait_schedule.h"
#include "sim/locomotion/roll_profile.h"
#include "sim/locomotion/swing_trajectory.h"

namespace atlas::sim {
namespace {

using core::Vec2;
using core::Vec3;

TEST(Foothold, SteadyWalkLandsHalfAStanceAhead) {
  FootholdInput in;
  in.v_base = in.v_command = Vec2(0.5, 0.0);
  in.nominal_base = Vec2(0.34, 0.235);
  const Vec2 expected = in.nominal_base + Vec2(0.5 * 0.5 * GaitSchedule::kStanceS, 0.0);
  EXPECT_LT((NominalFoothold(in) - expected).norm(), 1e-12);
}

TEST(Foothold, TurnsWithTheHeading) {
  FootholdInput in;
  in.v_base = Vec2(0.3, 0.1);
  in.v_command = Vec2(0.4, 0.0);
  in.nominal_base = Vec2(-0.34, 0.235);
  const Vec2 straight = NominalFoothold(in);
  const Eigen::Rotation2Dd R(1.1);
  in.v_base = R * in.v_base;
  in.v_command = R * in.v_command;
  in.yaw_rad = 1.1;
  EXPECT_LT((NominalFoothold(in) - R * straight).norm(), 1e-12);
}

/// Known everywhere; steppable where `steppable` says so.
template <typename F>
class Patches : public core::TerrainView {
 public:
  explicit Patches(F steppable) : steppable_(std::move(steppable)) {}
  Ground At(double x, double y) const override { return {0.0, true, steppable_(x, y)}; }

 private:
  F steppable_;
};

TEST(Foothold, NeverUnsteppableWhereTheWindowHoldsASteppablePlace) {
  core::Rng rng(3);
  for (int trial = 0; trial < 300; ++trial) {
    const Vec2 island(rng.Uniform(-0.14, 0.14), rng.Uniform(-0.06, 0.06));
    const Patches ground([&](double x, double y) { return (Vec2(x, y) - island).norm() < 0.04; });
    TerrainSampler terrain({});
    terrain.SetSource(GroundSource::kPerceived, &ground);
    const Foothold foothold = SearchFoothold(terrain, Vec2::Zero(), 0.0, 1.0);
    EXPECT_TRUE(foothold.steppable) << island.transpose();
    EXPECT_LT((foothold.offset - island).norm(), 0.04 + 1e-9);
  }
}

TEST(Foothold, CleanGroundKeepsTheNominalPlace) {
  const Patches ground([](double, double) { return true; });
  TerrainSampler terrain({});
  terrain.SetSource(GroundSource::kPerceived, &ground);
  EXPECT_EQ(SearchFoothold(terrain, Vec2(1.0, 2.0), 0.5, 1.0).offset.norm(), 0.0);
}

TEST(Foothold, MapIsReadWhereOdometryHasTheRobot) {
  // Odometry has the robot 1 m farther along x and 0.2 m higher than it is; the map has a step at x = 3.
  const auto height = [](double x, double) { return x > 3.0 ? 0.5 : 0.2; };
  const test::PerceivedTerrain<decltype(height)> map(height, 0.0, 1);
  TerrainSampler terrain({});
  terrain.SetSource(GroundSource::kPerceived, &map);
  terrain.SetOdometry(core::Pose(Eigen::Translation3d(1.0, 0.0, 0.2)));
  EXPECT_NEAR(terrain.At(1.9, 0.0).z, 0.0, 1e-12);
  EXPECT_NEAR(terrain.At(2.1, 0.0).z, 0.3, 1e-12);
}

TEST(Foothold, WhereTheMapKnowsNothingThePlaneOfTheFeetServes) {
  class Nothing : public core::TerrainView {
    Ground At(double, double) const override { return {}; }
  };
  const Nothing map;
  TerrainSampler terrain([](const Vec3&) { return std::optional<double>(7.0); });
  terrain.SetSource(GroundSource::kPerceived, &map);
  terrain.SetPlane({Vec3(0.0, 0.0, 1.0), Vec2(0.1, 0.0)});
  const TerrainSampler::Sample ground = terrain.At(2.0, 3.0);
  EXPECT_NEAR(ground.z, 1.2, 1e-12) << "not the true 7 m";
  EXPECT_FALSE(ground.known);
  EXPECT_FALSE(ground.steppable);
}

TEST(Swing, StartsLiftsAndLandsWhereAsked) {
  const SwingShape shape{Vec3(0.0, 0.0, 0.03), Vec3(0.2, 0.1, 0.13), 0.15};
  EXPECT_LT((SwingPoint(shape, 0.0) - shape.p_start).norm(), 1e-12);
  EXPECT_LT((SwingPoint(shape, 1.0) - shape.p_target).norm(), 0.0051);
  double top = 0.0;
  for (double s = 0.0; s <= 1.0; s += 0.01) top = std::max(top, SwingPoint(shape, s).z());
  EXPECT_NEAR(top, 0.15 + kSwingClearanceM, 1e-3);
}

TEST(Swing, ClearsAStepBeforeItTravels) {
  const SwingShape up{Vec3(0.0, 0.0, 0.0), Vec3(0.25, 0.0, 0.15), 0.15};
  for (double s = 0.0; s <= 1.0; s += 0.01) {
    const Vec3 p = SwingPoint(up, s);
    if (p.x() <= 0.06) continue;
    EXPECT_GT(p.z(), 0.15 - 0.006) << "s " << s;
  }
}

TEST(RollProfile, SweepsBothWaysAndEndsAtRest) {
  const RollProfile profile(0.7, 6.0);
  double low = 0.0, high = 0.0;
  for (double t = 0.0; t < 6.0; t += 0.002) {
    const BodyRoll roll = profile.At(t);
    low = std::min(low, roll.roll_rad);
    high = std::max(high, roll.roll_rad);
    const double difference = (profile.At(t + 1e-5).roll_rad - profile.At(t - 1e-5).roll_rad) / 2e-5;
    if (t < 1e-4) continue;
    EXPECT_NEAR(roll.rate_radps, difference, 1e-3) << "t " << t;
  }
  EXPECT_NEAR(high, 0.7, 1e-4);
  EXPECT_NEAR(low, -0.7, 1e-4);
  for (const double t : {0.0, 6.0}) {
    EXPECT_NEAR(profile.At(t).roll_rad, 0.0, 1e-9);
    EXPECT_NEAR(profile.At(t).rate_radps, 0.0, 1e-9);
    EXPECT_EQ(profile.At(t).level, 0.0);
  }
}

}  // namespace
}  // namespace atlas::sim
