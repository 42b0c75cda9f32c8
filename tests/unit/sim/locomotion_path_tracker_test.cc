#include <gtest/gtest.h>

#include "sim/locomotion/path_tracker.h"

namespace atlas::sim {
namespace {

using core::Vec2;

/// A base that obeys commands within its acceleration limits.
struct IdealBase {
  Vec2 p = Vec2::Zero();
  double yaw = 0.0;
  Vec2 v_map = Vec2::Zero();
  void Move(const VelocityCommand& command, double dt) {
    const Vec2 wanted = Eigen::Rotation2Dd(yaw) * Vec2(command.forward_mps, command.lateral_mps);
    const Vec2 change = wanted - v_map;
    v_map += change * std::min(1.0, 1.5 * dt / std::max(change.norm(), 1e-9));
    p += v_map * dt;
    yaw += command.yaw_radps * dt;
  }
};

double DistanceToPath(const std::vector<Vec2>& path, const Vec2& p) {
  double best = 1e9;
  for (size_t i = 0; i + 1 < path.size(); ++i) {
    const Vec2 way = path[i + 1] - path[i];
    const double u = std::clamp((p - path[i]).dot(way) / way.squaredNorm(), 0.0, 1.0);
    best = std::min(best, (p - path[i] - u * way).norm());
  }
  return best;
}

struct Walked {
  PathTracker::Status status = PathTracker::Status::kWalking;
  double time_s = 0.0;
  double farthest_m = 0.0;
  IdealBase base;
};

Walked Follow(const std::vector<Vec2>& waypoints, double final_yaw, double speed) {
  PathTracker tracker(waypoints, final_yaw, speed);
  std::vector<Vec2> path = waypoints;
  path.insert(path.begin(), Vec2::Zero());
  Walked walked;
  constexpr double kDt = 0.02;
  while (walked.time_s < 200.0) {
    const PathTracker::Output out = tracker.Update(walked.time_s, walked.base.p, walked.base.yaw);
    walked.status = out.status;
    if (out.status != PathTracker::Status::kWalking) break;
    walked.base.Move(out.command, kDt);
    walked.time_s += kDt;
    walked.farthest_m = std::max(walked.farthest_m, DistanceToPath(path, walked.base.p));
  }
  return walked;
}

TEST(PathTracker, StraightWayTakesLittleLongerThanItsLength) {
  const Walked walked = Follow({Vec2(6.0, 0.0)}, 0.0, 0.5);
  EXPECT_EQ(walked.status, PathTracker::Status::kArrived);
  EXPECT_LT(walked.time_s, 12.0 + 2.0);
  EXPECT_LT((walked.base.p - Vec2(6.0, 0.0)).norm(), 0.05);
}

TEST(PathTracker, RightAnglesAndHairpinsStayWithinTenCentimetres) {
  for (const double speed : {0.3, 0.5, 0.8}) {
    const Walked square = Follow({{3, 0}, {3, 2}, {1, 2}, {1, 0.5}}, 1.0, speed);
    EXPECT_EQ(square.status, PathTracker::Status::kArrived);
    EXPECT_LT(square.farthest_m, 0.10);
    const Walked hairpin = Follow({{3, 0}, {3, 0.4}, {0, 0.4}, {0, 0.8}, {3, 0.8}}, 0.0, speed);
    EXPECT_EQ(hairpin.status, PathTracker::Status::kArrived);
    EXPECT_LT(hairpin.farthest_m, 0.10);
    EXPECT_LT((hairpin.base.p - Vec2(3.0, 0.8)).norm(), 0.05);
  }
}

TEST(PathTracker, DenselySampledArcIsWalkedAtNearlyFullSpeed) {
  std::vector<Vec2> arc;
  for (int i = 1; i <= 30; ++i) {
    const double a = core::kPi * i / 30;
    arc.emplace_back(2.0 * std::sin(a), 2.0 - 2.0 * std::cos(a));
  }
  const Walked walked = Follow(arc, core::kPi, 0.5);
  EXPECT_EQ(walked.status, PathTracker::Status::kArrived);
  EXPECT_LT(walked.farthest_m, 0.08);
  EXPECT_LT(walked.time_s, 2.0 * core::kPi / 0.5 * 1.25);
}

TEST(PathTracker, TurnsOnTheSpotWhereThereIsNoWayToGo) {
  const Walked walked = Follow({}, 2.5, 0.5);
  EXPECT_EQ(walked.status, PathTracker::Status::kArrived);
  EXPECT_LT(walked.base.p.norm(), 0.05);
  EXPECT_NEAR(walked.base.yaw, 2.5, 0.06);
}

TEST(PathTracker, AFirstWaypointJustBehindDoesNotTurnTheRobotRound) {
  const Walked walked = Follow({Vec2(-0.1, 0.02), Vec2(2.0, 0.0)}, 0.0, 0.5);
  EXPECT_EQ(walked.status, PathTracker::Status::kArrived);
  EXPECT_LT(walked.time_s, 4.0 + 2.0);
}

TEST(PathTracker, ABaseThatDoesNotMoveIsStuckAfterEightSeconds) {
  PathTracker tracker({Vec2(3.0, 0.0)}, 0.0, 0.5);
  double t = 0.0;
  while (t < 20.0 && tracker.Update(t, Vec2::Zero(), 0.0).status == PathTracker::Status::kWalking) t += 0.02;
  EXPECT_NEAR(t, 8.0, 0.1);
}

}  // namespace
}  // namespace atlas::sim
