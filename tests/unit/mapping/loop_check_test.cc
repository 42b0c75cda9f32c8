#include "mapping/slam/loop_check.h"

#include <gtest/gtest.h>

#include <optional>

#include "tests/support/analytic_world.h"

namespace atlas::tests {
namespace {

using core::Pose;
using core::Vec3;
using core::Vec3f;
using mapping::CheckLoop;
using mapping::LoopCheckParams;
using mapping::LoopCheckResult;
using mapping::LoopScan;
using mapping::LoopVerdict;
using mapping::RangeView;

Pose At(double x, double y, double z, double yaw_deg) {
  return core::PoseFromXyzYaw(Vec3(x, y, z), core::Radians(yaw_deg));
}

/// The returns of a standing LiDAR in its own frame.
std::vector<Vec3f> ReturnsIn(const AnalyticWorld& world, const Pose& T_world_lidar, uint64_t seed) {
  core::LidarModel lidar = core::FindLidarModel("os0_64");
  lidar.columns = 512;
  core::Rng noise(seed);
  const core::SpinEvent spin = SpinThrough(world, lidar, 0.0, StandingAt(T_world_lidar), &noise);
  std::vector<Vec3f> points;
  for (size_t i = 0; i < spin.scan.size(); ++i) {
    if (spin.scan.kind[i] == core::ReturnKind::kHit)
      points.push_back(spin.scan.range_m[i] * spin.scan.direction_lidar[i]);
  }
  return points;
}

LoopScan ScanIn(const AnalyticWorld& world, const Pose& T_world_lidar, uint64_t seed) {
  return mapping::PrepareLoopScan(ReturnsIn(world, T_world_lidar, seed), {.voxel_m = 0.12});
}

AnalyticWorld BareRoom() {
  AnalyticWorld world;
  world.AddBox({{-4.0, -2.5, 0.0}, {4.0, 2.5, 2.7}});
  return world;
}

/// Furniture that half a turn about the middle of the room does not change.
AnalyticWorld SymmetricRoom() {
  AnalyticWorld world = BareRoom();
  world.AddBox({{-3.9, 1.5, 0.0}, {-2.5, 2.5, 2.0}});
  world.AddBox({{2.5, -2.5, 0.0}, {3.9, -1.5, 2.0}});
  return world;
}

AnalyticWorld FurnishedWorld() {
  AnalyticWorld world = SymmetricRoom();
  world.AddBox({{0.2, 1.5, 0.0}, {1.6, 2.5, 1.9}});
  world.AddPillar(-1.5, -1.2, 0.25, 0.0, 2.7);
  return world;
}

const Pose kA = At(-0.6, 0.3, 1.0, 20.0), kB = At(0.5, -0.4, 1.1, 140.0);
const Pose kHalfTurn = At(0.0, 0.0, 0.0, 180.0);

/// What place recognition would offer: the true pose and its half turn, some decimetres off.
std::vector<Pose> BothWays() {
  const Pose off = At(0.25, -0.2, -0.1, 4.0);
  return {kA.inverse() * kB * off, kA.inverse() * kHalfTurn * kB * off};
}

TEST(LoopCheck, TheSamePlaceIsAcceptedWithItsPose) {
  const AnalyticWorld room = FurnishedWorld();
  const LoopCheckResult found =
      CheckLoop(ScanIn(room, kA, 1), ScanIn(room, kB, 2), BothWays(), std::nullopt, {});
  EXPECT_EQ(found.verdict, LoopVerdict::kAccepted) << NameOf(found.verdict);
  const Pose error = (kA.inverse() * kB).inverse() * found.T_a_b;
  EXPECT_LT(error.translation().norm(), 0.01);
  EXPECT_LT(core::Degrees(Eigen::AngleAxisd(error.linear()).angle()), 0.1);
  // The error is what the information says of it: within 99.9 % of 6 degrees of freedom.
  const mapping::Vector6 xi = mapping::Difference(kA.inverse() * kB, found.T_a_b);
  EXPECT_LT(xi.dot(found.information * xi), 22.46);
  EXPECT_GT(found.information.diagonal().minCoeff(), 1.0 / (0.05 * 0.05));
}

TEST(LoopCheck, ASymmetricRoomIsAmbiguousUnlessTheGraphKnowsBetter) {
  const AnalyticWorld room = SymmetricRoom();
  const LoopScan a = ScanIn(room, kA, 3), b = ScanIn(room, kB, 4);
  EXPECT_EQ(CheckLoop(a, b, BothWays(), std::nullopt, {}).verdict, LoopVerdict::kAmbiguous);
  mapping::LoopEstimate estimate{kA.inverse() * kB, 0.04 * mapping::Matrix6::Identity()};
  const LoopCheckResult known = CheckLoop(a, b, BothWays(), estimate, {});
  EXPECT_EQ(known.verdict, LoopVerdict::kAccepted) << NameOf(known.verdict);
  EXPECT_LT((known.T_a_b.translation() - estimate.T_a_b.translation()).norm(), 0.02);
}

TEST(LoopCheck, ARoomThatTheEstimateForbidsIsOutsideTheGate) {
  const AnalyticWorld room = FurnishedWorld();
  const std::vector<Pose> starts = {BothWays()[0]};
  mapping::LoopEstimate elsewhere{At(30.0, 5.0, 0.0, 0.0), 0.25 * mapping::Matrix6::Identity()};
  EXPECT_EQ(CheckLoop(ScanIn(room, kA, 5), ScanIn(room, kB, 6), starts, elsewhere, {}).verdict,
            LoopVerdict::kGate);
}

TEST(LoopCheck, AnotherRoomOfTheSameWallsIsRefusedByWhatStandsInTheBeams) {
  AnalyticWorld other = SymmetricRoom();
  other.AddBox({{-0.9, -0.5, 0.0}, {-0.2, 0.6, 1.5}});
  const LoopScan a = ScanIn(SymmetricRoom(), kA, 7), b = ScanIn(other, At(1.5, -0.8, 1.1, 140.0), 8);
  const std::vector<Pose> starts = {kA.inverse() * At(1.5, -0.8, 1.1, 140.0)};
  const LoopCheckResult found = CheckLoop(a, b, starts, std::nullopt, {});
  EXPECT_EQ(found.verdict, LoopVerdict::kInFront) << NameOf(found.verdict);
  LoopCheckParams params;
  params.max_in_front = 1.0;
  EXPECT_NE(CheckLoop(a, b, starts, std::nullopt, params).verdict, LoopVerdict::kInFront);
}

TEST(LoopCheck, ABareCorridorIsDegenerate) {
  AnalyticWorld corridor;
  corridor.AddPlane(Vec3::UnitY(), -0.9);
  corridor.AddPlane(Vec3::UnitY(), 0.9);
  corridor.AddPlane(Vec3::UnitZ(), 0.0);
  corridor.AddPlane(Vec3::UnitZ(), 2.5);
  const std::vector<Pose> starts = {Pose::Identity()};
  EXPECT_EQ(CheckLoop(ScanIn(corridor, At(0, 0, 1, 30), 9), ScanIn(corridor, At(7, 0.1, 1, 30), 10), starts,
                      std::nullopt, {})
                .verdict,
            LoopVerdict::kDegenerate);
}

TEST(LoopCheck, WithoutAStartNothingIsFound) {
  const LoopScan a = ScanIn(FurnishedWorld(), kA, 11);
  EXPECT_FALSE(CheckLoop(a, a, {}, std::nullopt, {}).accepted());
}

TEST(LoopCheck, DifferenceUndoesPerturbation) {
  core::Rng rng(12);
  for (const double size : {0.0, 1e-9, 1e-4, 0.5, 1.5}) {
    mapping::Vector6 xi;
    for (int i = 0; i < 6; ++i) xi[i] = size * rng.Uniform(-1.0, 1.0);
    EXPECT_LT((mapping::Difference(kA, mapping::Perturbed(kA, xi)) - xi).norm(), 1e-9) << size;
  }
}

TEST(RangeView, TellsInFrontFromBehind) {
  const RangeView view(ReturnsIn(BareRoom(), At(0.0, 0.0, 1.2, 0.0), 13));
  EXPECT_EQ(view.Of(Vec3f(2.0f, 0.0f, 0.0f), 0.2f), RangeView::Sight::kInFront);
  EXPECT_EQ(view.Of(Vec3f(3.95f, 0.0f, 0.0f), 0.2f), RangeView::Sight::kAtSurface);
  EXPECT_EQ(view.Of(Vec3f(5.0f, 0.0f, 0.0f), 0.2f), RangeView::Sight::kHidden);
  EXPECT_EQ(view.Of(Vec3f(0.05f, 0.0f, -1.0f), 0.2f), RangeView::Sight::kUnknown);  // below the beams
}

TEST(RangeView, PastTheEdgeOfTheFieldOfViewNothingPassed) {
  // Floor seen from 0.6 m by rows down to 17 degrees; the same floor nearer by lies below them.
  std::vector<Vec3f> floor;
  for (double azimuth = -180.0; azimuth < 180.0; azimuth += 0.5) {
    for (double below = 3.0; below <= 17.0; below += 0.5) {
      const double range = 0.6 / std::sin(core::Radians(below)), a = core::Radians(azimuth);
      const double flat = range * std::cos(core::Radians(below));
      floor.push_back(core::Vec3(flat * std::cos(a), flat * std::sin(a), -0.6).cast<float>());
    }
  }
  const RangeView view(floor);
  const auto at = [&](double below) {
    return view.Of(Vec3f(static_cast<float>(0.6 / std::tan(core::Radians(below))), 0.0f, -0.6f), 0.1f);
  };
  EXPECT_EQ(at(12.0), RangeView::Sight::kAtSurface);
  EXPECT_EQ(at(19.5), RangeView::Sight::kUnknown);
  EXPECT_EQ(at(22.0), RangeView::Sight::kUnknown);
}

}  // namespace
}  // namespace atlas::tests
