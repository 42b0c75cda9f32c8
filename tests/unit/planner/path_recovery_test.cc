#include "planner/travel/recovery.h"

#include <gtest/gtest.h>

#include "tests/support/flat_ground.h"
#include "tests/support/moved_keyframes.h"

namespace atlas::planner {
namespace {

using core::Vec2;
using core::Vec3;

core::Pose At(const Vec2& p, double yaw_rad) {
  return core::PoseFromXyzYaw(Vec3(p.x(), p.y(), 0.44), yaw_rad);
}

/// Free in a wedge of 20 degrees about one direction from a place, and nowhere else.
class Wedge : public tests::FlatGround {
 public:
  Wedge(const Vec2& apex, double direction_rad) : apex_(apex), direction_rad_(direction_rad) {}
  mapping::GroundKind KindAt(const core::Vec3& p) const override {
    const double off = std::atan2(p.y() - apex_.y(), p.x() - apex_.x()) - direction_rad_;
    return std::abs(core::WrapAngle(off)) < core::Radians(10.0) ? mapping::GroundKind::kFree
                                                                : mapping::GroundKind::kObstacle;
  }

 private:
  Vec2 apex_;
  double direction_rad_;
};

const tests::MovedKeyframes kStill;
const std::vector<Vec2> kWay = {Vec2(0, 0), Vec2(2, 0), Vec2(2, 1), Vec2(3, 1)};

TEST(Recovery, TheRobotGoesBackTheWayItCameAndLooksAlongIt) {
  Recovery recovery;
  recovery.SetOut(tests::OnFloor(kWay), kStill);
  const Vec2 here(3.1, 1.2);  // not quite where the way ended
  const auto back = recovery.Next(At(here, 0.3), tests::FlatGround(), kStill);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->path_map, (std::vector<Vec2>{here, Vec2(2, 1), Vec2(2, 0), Vec2(0, 0)}));
  EXPECT_NEAR(back->yaw_rad, core::kPi, 1e-12) << "from (2, 0) to (0, 0)";
}

TEST(Recovery, TheWayBackMovesWithTheKeyframeThatItWasPlannedFrom) {
  const core::Pose before = core::PoseFromXyzYaw({1.0, 2.0, 0.0}, 0.4),
                   after = core::PoseFromXyzYaw({-2.0, 0.5, 0.0}, 1.9);
  const core::Pose T = after * before.inverse();
  Recovery recovery;
  recovery.SetOut(tests::OnFloor(kWay), tests::MovedKeyframes({before}));
  const auto moved = [&](const Vec2& p) -> Vec2 { return (T * Vec3(p.x(), p.y(), 0.0)).head<2>(); };
  const Vec2 here = moved(kWay.back());
  const auto back = recovery.Next(At(here, 0.0), tests::FlatGround(), tests::MovedKeyframes({after}, 1));
  ASSERT_TRUE(back);
  ASSERT_EQ(back->path_map.size(), kWay.size());
  for (size_t i = 0; i < kWay.size(); ++i) {
    EXPECT_LT((back->path_map[i] - moved(kWay[kWay.size() - 1 - i])).norm(), 1e-9) << i;
  }
  EXPECT_NEAR(core::WrapAngle(back->yaw_rad - core::kPi - 1.5), 0.0, 1e-9) << "turned as the map was";
}

TEST(Recovery, OnlyOnItsWayIsThereAWayBack) {
  for (const double off_m : {0.49, 0.51}) {
    Recovery recovery;
    recovery.SetOut(tests::OnFloor(kWay), kStill);
    const Vec2 here(3.0, 1.0 + off_m);
    const auto move = recovery.Next(At(here, 0.0), tests::FlatGround(), kStill);
    ASSERT_TRUE(move);
    EXPECT_EQ(move->path_map.size(), off_m < 0.5 ? 4u : 1u) << off_m;
  }
}

TEST(Recovery, BackThenATurnThenAStepThenNothing) {
  Recovery recovery;
  recovery.SetOut(tests::OnFloor(kWay), kStill);
  const tests::FlatGround free;
  const Vec2 start = kWay.front();
  EXPECT_EQ(recovery.Next(At(kWay.back(), 0.0), free, kStill)->path_map.back(), start);
  const auto turn = recovery.Next(At(start, 2.0), free, kStill);
  ASSERT_TRUE(turn);
  EXPECT_EQ(turn->path_map, std::vector<Vec2>{start});
  EXPECT_NEAR(turn->yaw_rad, 2.0 + 0.5 * core::kPi - 2.0 * core::kPi, 1e-12);
  const auto step = recovery.Next(At(start, 1.0), free, kStill);
  ASSERT_TRUE(step);
  ASSERT_EQ(step->path_map.size(), 2u);
  EXPECT_EQ(step->path_map.front(), start);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(recovery.Next(At(start, 1.0), free, kStill)) << "all was tried";

  recovery.SetOut(tests::OnFloor({start, Vec2(1, 0)}), kStill);
  EXPECT_EQ(recovery.Next(At(Vec2(1, 0), 0.0), free, kStill)->path_map.size(), 2u)
      << "and again after setting out";
  EXPECT_EQ(recovery.Next(At(start, 0.0), free, kStill)->path_map.size(), 1u);
  EXPECT_EQ(recovery.Next(At(start, 0.0), free, kStill)->path_map.size(), 2u);
  EXPECT_FALSE(recovery.Next(At(start, 0.0), free, kStill));
}

TEST(Recovery, TheStepGoesWhereMostGroundIsFree) {
  for (const double yaw : {0.0, 2.5, -1.0}) {
    for (const double off_deg : {0.0, 90.0, -135.0}) {
      const double direction = yaw + core::Radians(off_deg);
      const Vec2 here(0.7, -0.4);
      const Wedge ground(here, direction);
      Recovery recovery;
      ASSERT_EQ(recovery.Next(At(here, yaw), ground, kStill)->path_map.size(), 1u) << "a turn first";
      const auto step = recovery.Next(At(here, yaw), ground, kStill);
      ASSERT_TRUE(step);
      const Vec2 there = here + 0.3 * Vec2(std::cos(direction), std::sin(direction));
      EXPECT_LT((step->path_map.back() - there).norm(), 1e-9) << yaw << " " << off_deg;
      EXPECT_NEAR(core::WrapAngle(step->yaw_rad - direction), 0.0, 1e-9);
    }
  }
}

TEST(Recovery, WhereNothingIsFreeThereIsNoStep) {
  tests::FlatGround nothing;
  nothing.AddObstacle(Vec2(-9, -9), Vec2(9, 9));
  Recovery recovery;
  EXPECT_TRUE(recovery.Next(At(Vec2::Zero(), 0.0), nothing, kStill)) << "a turn needs no ground";
  EXPECT_FALSE(recovery.Next(At(Vec2::Zero(), 0.0), nothing, kStill));
}

}  // namespace
}  // namespace atlas::planner
