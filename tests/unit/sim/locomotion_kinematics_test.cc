#include <gtest/gtest.h>

#include "core/rng.h"
#include "locomotion_scenes.h"
#include "robots/robot_spec.h"
#include "sim/world/leg_kinematics.h"
#include "sim/world/world.h"

namespace atlas::sim {
namespace {

using core::Radians;
using core::Vec3;

/// A posture within the joint ranges, knees bent the way that each leg bends.
Vec12 RandomPosture(const World& world, core::Rng* rng) {
  Vec12 joints;
  for (int i = 0; i < kLegs; ++i) {
    joints.segment<3>(3 * i) = Vec3(rng->Uniform(-1.0, 1.0), world.leg(i).fore * rng->Uniform(-0.3, 1.5),
                                    -world.leg(i).fore * rng->Uniform(Radians(12.0), Radians(150.0)));
  }
  return joints;
}

class LegKinematics : public ::testing::Test {
 protected:
  World world_{test::FlatScene(), robots::LoadRobot("quadruped")};
  core::Rng rng_{5};
};

TEST_F(LegKinematics, ForwardKinematicsEqualsMujoco) {
  for (int trial = 0; trial < 200; ++trial) {
    const Vec12 joints = RandomPosture(world_, &rng_);
    const core::Pose T_map_base = core::MakePose(
        core::RotationFromYawPitchRoll(rng_.Uniform(-3.0, 3.0), 0.3, -0.4), Vec3(0.3, -2.0, 1.0));
    world_.Place(T_map_base, joints);
    for (int i = 0; i < kLegs; ++i) {
      const Vec3 p_map = T_map_base * FootPosition(world_.leg(i), joints.segment<3>(3 * i));
      EXPECT_LT((p_map - world_.state().leg[static_cast<size_t>(i)].p_foot).norm(), 1e-6);
    }
  }
}

TEST_F(LegKinematics, SolvedAnglesPutMujocosFeetWhereTheyWereAsked) {
  for (int trial = 0; trial < 200; ++trial) {
    const Vec12 joints = RandomPosture(world_, &rng_);
    Vec12 solved;
    bool below = true;
    for (int i = 0; i < kLegs; ++i) {
      const Vec3 p_base = FootPosition(world_.leg(i), joints.segment<3>(3 * i));
      const LegAngles angles = SolveLeg(world_.leg(i), p_base);
      EXPECT_TRUE(angles.reachable);
      solved.segment<3>(3 * i) = angles.q;
      below = below && (p_base - world_.leg(i).haa_base).z() < -0.1;
    }
    if (!below) continue;  // feet above the hips have a second abduction angle
    world_.Place(core::Pose::Identity(), solved);
    for (int i = 0; i < kLegs; ++i) {
      const Vec3 wanted = FootPosition(world_.leg(i), joints.segment<3>(3 * i));
      EXPECT_LT((wanted - world_.state().leg[static_cast<size_t>(i)].p_foot).norm(), 1e-6);
    }
  }
}

TEST_F(LegKinematics, FeetOutOfReachGetTheStretchedLeg) {
  const LegGeometry& leg = world_.leg(0);
  const LegAngles angles = SolveLeg(leg, leg.haa_base + Vec3(0.1, leg.lateral_m, -2.0));
  EXPECT_FALSE(angles.reachable);
  const Vec3 p = FootPosition(leg, angles.q);
  EXPECT_NEAR((p - leg.haa_base - Vec3(leg.hfe_forward_m, leg.lateral_m, 0.0)).norm(),
              leg.thigh_m + leg.shank_m, 1e-3);
}

TEST_F(LegKinematics, FootJacobiansEqualFiniteDifferences) {
  const core::Pose T = core::MakePose(core::RotationFromYawPitchRoll(0.7, -0.2, 0.3), Vec3(1.0, 2.0, 1.0));
  const Vec12 joints = RandomPosture(world_, &rng_);
  world_.Place(T, joints);
  const RobotState at = world_.state();
  constexpr double kEps = 1e-6;
  for (int column = 0; column < kDofs; ++column) {
    core::Pose T_moved = T;
    Vec12 joints_moved = joints;
    if (column < 3) T_moved.translation()[column] += kEps;
    if (column >= 3 && column < 6) T_moved.rotate(Eigen::AngleAxisd(kEps, Vec3::Unit(column - 3)));
    if (column >= 6) joints_moved[column - 6] += kEps;
    world_.Place(T_moved, joints_moved);
    for (size_t i = 0; i < kLegs; ++i) {
      const Vec3 difference = (world_.state().leg[i].p_foot - at.leg[i].p_foot) / kEps;
      Vec3 jacobian = Vec3::Zero();
      if (column < 6) jacobian = at.leg[i].J_base.col(column);
      if (column >= 6 && (column - 6) / 3 == static_cast<int>(i))
        jacobian = at.leg[i].J_leg.col((column - 6) % 3);
      EXPECT_LT((difference - jacobian).norm(), 1e-5) << "leg " << i << " column " << column;
    }
  }
}

}  // namespace
}  // namespace atlas::sim
