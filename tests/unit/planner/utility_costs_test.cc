#include <gtest/gtest.h>

#include "planner/stopping/termination.h"
#include "planner/stopping/view_memory.h"
#include "planner/travel/costs.h"
#include "tests/support/flat_ground.h"
#include "tests/support/moved_keyframes.h"
#include "tests/support/voxel_world.h"

namespace atlas::planner {
namespace {

const tests::MovedKeyframes kUnmoved;

using core::Vec2;
using core::Vec3;

TEST(Costs, PositionCostIsEquation37) {
  EXPECT_DOUBLE_EQ(PositionCost(0.0, 2.0), 1.0);
  EXPECT_DOUBLE_EQ(PositionCost(0.5, 2.0), 0.75);
  EXPECT_DOUBLE_EQ(PositionCost(2.0, 2.0), 0.0);
  EXPECT_DOUBLE_EQ(PositionCost(7.0, 2.0), 0.0);
}

TEST(Costs, TwoTermsAtOneThresholdHaveTheThesissMaximum) {
  // The thesis has one d_x: the distance to a visited pose or the object, whichever is nearer.
  for (const double threshold : {0.5, 1.5, 3.0}) {
    for (double visited = 0.0; visited < 4.0; visited += 0.3) {
      for (double object = 0.0; object < 4.0; object += 0.3) {
        EXPECT_DOUBLE_EQ(std::max(PositionCost(visited, threshold), PositionCost(object, threshold)),
                         PositionCost(std::min(visited, object), threshold));
      }
    }
  }
}

TEST(Costs, UtilityIsEquation31) {
  const struct {
    double gain, position, traversal, utility;
  } table[] = {{10, 0, 0, 10},      {10, 0.5, 0, 5}, {10, 0, 0.25, 7.5},
               {10, 0.5, 0.5, 2.5}, {10, 1, 0, 0},   {0, 0, 0, 0}};
  for (const auto& row : table) EXPECT_DOUBLE_EQ(Utility(row.gain, row.position, row.traversal), row.utility);
}

TEST(Costs, TwoTraversalCostsLeaveTheProductOfWhatTheyLeave) {
  EXPECT_DOUBLE_EQ(CombineCosts(0.0, 0.2), 0.2);
  EXPECT_DOUBLE_EQ(CombineCosts(0.5, 0.2), 0.6);
  EXPECT_DOUBLE_EQ(CombineCosts(1.0, 0.2), 1.0);
}

TEST(Costs, ObjectDistanceLeavesTheGroundOut) {
  tests::VoxelWorld world({Vec3(-2, -2, -0.5), Vec3(2, 2, 1.5)}, 0.1);
  world.Fill([](const Vec3& p) { return p.z() < 0.0 || (p.x() > 1.0 && p.z() < 1.0) ? 0.95f : 0.1f; });
  const ObjectDistance object(world, world.region(), 0.0);
  const Vec3 sensor(0.0, 0.05, 0.65);
  EXPECT_NEAR(object.At(sensor, 5.0), 1.05, 0.01);
  EXPECT_NEAR(object.At(sensor, 0.8), 0.8, 1e-6) << "limited";
}

TEST(Costs, BehindIsTheHalfPlaneAtTheRobotsBack) {
  const core::Pose robot = core::PoseFromXyzYaw(Vec3(1.0, 1.0, 0.44), 0.5 * core::kPi);
  EXPECT_FALSE(IsBehind(Vec2(1.0, 2.0), robot));
  EXPECT_FALSE(IsBehind(Vec2(4.0, 1.1), robot));
  EXPECT_TRUE(IsBehind(Vec2(4.0, 0.9), robot));
}

class TiltedGround : public tests::FlatGround {
 public:
  double slope_rad = 0.0;
  Surface SurfaceAt(const core::Vec3&) const override { return {0.0, slope_rad, 0.0}; }
};

TEST(Costs, WalkTimeCountsLengthTurnsAndSlope) {
  TiltedGround ground;
  const Walkable walkable(ground, Vec2::Zero());
  TraversalModel model;
  model.speed_mps = 0.5;
  model.turn_rate_radps = 0.5;
  const std::vector<Vec2> path = {Vec2(0, 0), Vec2(2, 0), Vec2(2, 1)};
  EXPECT_NEAR(WalkTime(model, walkable, tests::OnFloor(path), 0.0, 0.5 * core::kPi),
              3.0 / 0.5 + 0.5 * core::kPi / 0.5, 1e-9);
  EXPECT_NEAR(WalkTime(model, walkable, tests::OnFloor(path), core::kPi, 0.0), 6.0 + 2.0 * core::kPi / 0.5,
              1e-9);
  ground.slope_rad = model.slope_scale_rad;
  EXPECT_NEAR(WalkTime(model, walkable, tests::OnFloor(path), 0.0, 0.5 * core::kPi), 12.0 + core::kPi, 1e-9)
      << "half the speed";
  EXPECT_NEAR(ContinuousTraversalCost(model, model.time_scale_s), 1.0 - std::exp(-1.0), 1e-12);
  EXPECT_EQ(ContinuousTraversalCost(model, 0.0), 0.0);
}

TEST(Termination, TheThesissThresholdEndsWithTheFirstPlanBelowIt) {
  EXPECT_FALSE(BelowThreshold(50.0, 50.0)) << "Eq. 3.8 is strict";
  EXPECT_TRUE(BelowThreshold(49.9, 50.0));
  EXPECT_FALSE(BelowThreshold(1e-9, 0.0));
  EXPECT_TRUE(BelowThreshold(0.0, 0.0)) << "nothing to go to";
}

TEST(Termination, StopsOnlyWhereRoundsAreLowOnAverageOnAFlatCurve) {
  Termination low({.stop_ratio = 0.05, .stop_rounds = 2, .flat_share = 0.01, .flat_rounds = 100});
  for (const double utility : {100.0, 3.0, 20.0, 3.0}) {
    low.Observe(utility, 0.0);
    EXPECT_FALSE(low.GainExhausted());
  }
  EXPECT_NEAR(low.ratio(), 0.03, 1e-12);
  low.Observe(3.0, 0.2);
  EXPECT_FALSE(low.GainExhausted()) << "the surface still grows";
  low.Observe(3.0, 0.0);
  low.Observe(6.0, 0.0);
  EXPECT_TRUE(low.GainExhausted()) << "4.5 % on average";
}

TEST(Termination, DoesNotDependOnTheGainsScale) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Termination t({.stop_ratio = 0.05, .stop_rounds = 2, .flat_share = 0.01, .flat_rounds = 100});
    for (const double u : {50.0, 30.0, 2.0}) t.Observe(scale * u, 0.002);
    EXPECT_FALSE(t.GainExhausted());
    t.Observe(scale * 1.0, 0.002);
    EXPECT_TRUE(t.GainExhausted());
  }
}

TEST(Termination, MeasuresByTheGreatestUtilityNotByAPoorFirstView) {
  Termination t({.stop_ratio = 0.05, .stop_rounds = 2, .flat_share = 0.01, .flat_rounds = 100});
  for (const double u : {5.0, 100.0, 3.0}) t.Observe(u, 0.0);
  EXPECT_NEAR(t.ratio(), 0.03, 1e-12);
  EXPECT_FALSE(t.GainExhausted());
  t.Observe(3.0, 0.0);
  EXPECT_TRUE(t.GainExhausted());
}

TEST(Termination, TheSurfaceMustBeFlatOverTheLowRoundsOnAverage) {
  Termination t({.stop_ratio = 0.05, .stop_rounds = 2, .flat_share = 0.015, .flat_rounds = 100});
  t.Observe(100.0, 1.0);
  t.Observe(1.0, 0.028);
  t.Observe(1.0, 0.014);
  EXPECT_FALSE(t.GainExhausted()) << "2.1 % a sweep";
  t.Observe(1.0, 0.015);
  EXPECT_TRUE(t.GainExhausted()) << "1.45 % a sweep";
}

TEST(Termination, AGainThatNeverFallsIsOverruledByFlatSweeps) {
  Termination t({.stop_ratio = 0.05, .stop_rounds = 2, .flat_share = 0.01, .flat_rounds = 4});
  t.Observe(100.0, 1.0);
  for (int i = 0; i < 3; ++i) t.Observe(120.0, 0.002);
  EXPECT_FALSE(t.SurfaceFlat());
  t.Observe(120.0, 0.3);
  for (int i = 0; i < 3; ++i) t.Observe(120.0, 0.002);
  EXPECT_FALSE(t.SurfaceFlat()) << "a sweep that brought something starts the count again";
  t.Observe(120.0, 0.002);
  EXPECT_TRUE(t.SurfaceFlat());
  EXPECT_FALSE(t.GainExhausted()) << "utility stands high: the ending has another name";
}

core::Pose Standing(double x) {
  return core::PoseFromXyzYaw(Vec3(x, 0.0, 0.44), 0.0);
}

TEST(ViewMemory, APromiseThatBringsNothingCountsAsBrokenWhereItWasMade) {
  ViewMemory memory;
  memory.RecordSweep(Standing(0.0), 10000, kUnmoved);
  memory.Commit({Vec2(3.0, 0.0), 0.0}, kUnmoved);
  memory.RecordSweep(Standing(3.1), 2, kUnmoved);
  EXPECT_EQ(memory.BrokenPromisesNear(Vec2(3.0, 0.0)), 1);
  EXPECT_EQ(memory.BrokenPromisesNear(Vec2(4.5, 0.0)), 0);
  EXPECT_FALSE(memory.commitment().has_value());
  memory.Commit({Vec2(3.0, 0.0), 0.0}, kUnmoved);
  memory.RecordSweep(Standing(3.0), 5000, kUnmoved);
  EXPECT_EQ(memory.BrokenPromisesNear(Vec2(3.0, 0.0)), 1) << "kept";
}

TEST(ViewMemory, TrustGrowsWithTheDistanceToBrokenPromises) {
  ViewMemory memory;
  memory.RecordSweep(Standing(0.0), 10000, kUnmoved);
  EXPECT_EQ(memory.TrustAt(Vec2(1.0, 2.0), 6.0), 1.0) << "nothing was broken yet";
  for (const double x : {3.0, 9.0}) {
    memory.Commit({Vec2(x, 0.0), 0.0}, kUnmoved);
    memory.RecordSweep(Standing(x), 2, kUnmoved);
  }
  EXPECT_EQ(memory.TrustAt(Vec2(3.0, 0.0), 6.0), 0.0);
  // 6 m from one and, by the right angle, the root of 72 m from the other.
  EXPECT_NEAR(memory.TrustAt(Vec2(3.0, 6.0), 6.0), (1.0 - std::exp(-1.0)) * (1.0 - std::exp(-2.0)), 1e-12);
  EXPECT_NEAR(memory.TrustAt(Vec2(60.0, 0.0), 6.0), 1.0, 1e-12);
}

TEST(ViewMemory, ACommitmentStaysUntilASweepIsTakenThere) {
  ViewMemory memory;
  memory.RecordSweep(Standing(0.0), 10000, kUnmoved);
  memory.Commit({Vec2(3.0, 0.0), 0.0}, kUnmoved);
  memory.RecordSweep(Standing(1.5), 3, kUnmoved);
  EXPECT_TRUE(memory.commitment().has_value());
  EXPECT_EQ(memory.BrokenPromisesNear(Vec2(1.5, 0.0)), 0) << "nothing was promised here";
}

/// Told in a map that is then turned and shifted: the same answers about the same things.
TEST(ViewMemory, MovesWithTheKeyframes) {
  const core::Pose before = core::PoseFromXyzYaw(Vec3(1.0, -2.0, 0.3), 0.4),
                   after = core::PoseFromXyzYaw(Vec3(1.6, -1.5, 0.2), 0.9), T = after * before.inverse();
  const tests::MovedKeyframes then({before}), now({after}, 1);
  ViewMemory memory;
  memory.RecordSweep(Standing(0.0), 10000, then);
  memory.Commit({Vec2(3.0, 0.0), 0.0}, then);
  memory.RecordSweep(Standing(3.0), 2, then);
  memory.Commit({Vec2(5.0, 1.0), 0.25}, then);
  memory.Correct(now);
  const auto moved = [&](const Vec2& p) { return Vec2((T * Vec3(p.x(), p.y(), 0.44)).head<2>()); };
  ASSERT_EQ(memory.visited().size(), 2u);
  EXPECT_LT((memory.visited()[0] - moved(Vec2(0.0, 0.0))).norm(), 1e-9);
  EXPECT_LT((memory.visited()[1] - moved(Vec2(3.0, 0.0))).norm(), 1e-9);
  EXPECT_EQ(memory.BrokenPromisesNear(moved(Vec2(3.0, 0.0))), 1);
  EXPECT_LT((memory.commitment()->p_map - moved(Vec2(5.0, 1.0))).norm(), 1e-9);
  EXPECT_NEAR(memory.commitment()->yaw_rad, 0.25 + 0.5, 1e-9);
}

}  // namespace
}  // namespace atlas::planner
