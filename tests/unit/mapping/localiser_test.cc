// Localisers against the statistics that their parameters state.
#include "mapping/slam/localiser.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/errors.h"
#include "core/stopwatch.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::Vec3;

constexpr LocalisationParams Exact(double period_s) {
  return {.name = "truth", .sigma_m = 0.0, .sigma_deg = 0.0, .period_s = period_s};
}

/// A robot whose odometry is off by a pose that the test moves.
struct Drifting {
  explicit Drifting(const LocalisationParams& params, uint64_t seed = 3)
      : localiser(MakeLocaliser(params,
                                {.T_map_odom = T_map_odom_true,
                                 .T_odom_base = T_map_odom_true.inverse() * T_map_base,
                                 .T_map_base_true = [this] { return T_map_base; }},
                                core::Rng(seed))) {}

  void State(double time_s) {
    core::StateEvent state;
    state.time_s = time_s;
    state.T_odom_base = T_map_odom_true.inverse() * T_map_base;
    localiser->OnState(state);
  }
  Pose Believed() const { return localiser->T_map_odom() * (T_map_odom_true.inverse() * T_map_base); }

  Pose T_map_base = core::MakePose(core::RotationFromYawPitchRoll(0.7, 0.1, -0.2), Vec3(3.0, -2.0, 0.5));
  Pose T_map_odom_true = core::PoseFromXyzYaw({1.0, 1.0, 0.0}, 0.3);
  std::unique_ptr<Localiser> localiser;
};

std::shared_ptr<const core::SpinEvent> Spin(bool scanning) {
  core::SpinEvent spin;
  spin.scanning = scanning;
  return std::make_shared<const core::SpinEvent>(spin);
}

TEST(TruthLocaliser, ErrsByItsSigmasOnEveryAxis) {
  Drifting robot({.name = "truth", .sigma_m = 0.03, .sigma_deg = 0.5, .period_s = 1.0});
  Vec3 shift2 = Vec3::Zero(), turn2 = Vec3::Zero();
  constexpr int kDraws = 4000;
  for (int second = 1; second <= kDraws; ++second) {
    robot.State(second);
    const Pose believed = robot.Believed();
    shift2 += (believed.translation() - robot.T_map_base.translation()).cwiseAbs2();
    const Eigen::AngleAxisd turn(core::Mat3(believed.linear() * robot.T_map_base.linear().transpose()));
    turn2 += (turn.angle() * turn.axis()).cwiseAbs2();
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(std::sqrt(shift2[axis] / kDraws), 0.03, 0.05 * 0.03) << axis;
    EXPECT_NEAR(core::Degrees(std::sqrt(turn2[axis] / kDraws)), 0.5, 0.05 * 0.5) << axis;
  }
}

TEST(TruthLocaliser, TakesDriftBackOnceAPeriodAndNotInBetween) {
  Drifting robot(Exact(1.0));
  EXPECT_LT((robot.Believed().matrix() - robot.T_map_base.matrix()).norm(), 1e-9) << "from the start";
  for (int state = 0; state <= 200; ++state) {
    // Odometry slips by a millimetre a state; what is believed follows it until the next fix.
    robot.T_map_odom_true.translation().x() -= 0.001;
    robot.State(0.02 * state);
    const double error = (robot.Believed().translation() - robot.T_map_base.translation()).norm();
    EXPECT_NEAR(error, 0.001 * (state % 50), 1e-9) << state;
  }
}

TEST(TruthLocaliser, WithoutAPeriodItIsRightAtEveryState) {
  Drifting robot(Exact(0.0));
  for (int state = 0; state < 20; ++state) {
    robot.T_map_odom_true.translation().y() += 0.01;
    robot.State(0.02 * state);
    EXPECT_LT((robot.Believed().matrix() - robot.T_map_base.matrix()).norm(), 1e-9);
  }
}

TEST(NoLocaliser, NeverTakesDriftBack) {
  Drifting robot({.name = "none", .sigma_m = 0.1, .sigma_deg = 1.0, .period_s = 0.0});
  const Pose start = robot.T_map_odom_true;
  robot.T_map_odom_true.translation().y() += 0.5;
  for (int state = 0; state < 20; ++state) robot.State(state);
  EXPECT_EQ(robot.localiser->T_map_odom().matrix(), start.matrix());
  const core::AnchoredSpin spin = robot.localiser->Place(Spin(false));
  EXPECT_EQ(spin.T_map_odom(*robot.localiser->poses()).matrix(), start.matrix());
}

TEST(TruthLocaliser, RevolutionsLieWhereTheLatestFixPutThemAndThoseOfAScanWhereItBegan) {
  Drifting robot(Exact(1.0));
  std::vector<core::AnchoredSpin> placed;
  std::vector<double> put_x;
  const auto place = [&](bool scanning) {
    placed.push_back(robot.localiser->Place(Spin(scanning)));
    put_x.push_back(robot.localiser->T_map_odom().translation().x());
  };
  const auto slip = [&](double time_s) {
    robot.T_map_odom_true.translation().x() += 0.25;
    robot.State(time_s);
  };
  place(false);
  slip(1.0);
  place(false);
  place(false);
  place(true);
  slip(2.0);
  place(true);  // goes on
  place(false);
  slip(3.0);
  place(true);  // another one
  const auto poses = robot.localiser->poses();
  const std::vector<double> expected = {put_x[0], put_x[1], put_x[1], put_x[1], put_x[1], put_x[5], put_x[6]};
  for (size_t i = 0; i < placed.size(); ++i) {
    EXPECT_EQ(placed[i].T_map_odom(*poses).translation().x(), expected[i]) << i;
  }
  EXPECT_LT(put_x[0], put_x[1]);
  EXPECT_LT(put_x[1], put_x[5]);
  EXPECT_LT(put_x[5], put_x[6]);
}

TEST(TruthLocaliser, KeyframesStayWhereTheyAreWhateverComesLater) {
  Drifting robot({.name = "truth", .sigma_m = 0.1, .sigma_deg = 1.0, .period_s = 1.0});
  const core::AnchoredSpin spin = robot.localiser->Place(Spin(false));
  const auto before = robot.localiser->poses();
  const Pose here = spin.T_map_odom(*before);
  for (int second = 1; second < 10; ++second) {
    robot.State(second);
    robot.localiser->Place(Spin(false));
  }
  const auto after = robot.localiser->poses();
  EXPECT_EQ(spin.T_map_odom(*after).matrix(), here.matrix());
  EXPECT_EQ(spin.T_map_odom(*before).matrix(), here.matrix()) << "an old snapshot holds";
  EXPECT_EQ(after->version(), before->version());
}

/// A keyframe a revolution, a snapshot a keyframe. With copies it would be 30 GB.
TEST(TruthLocaliser, ManySnapshotsOfManyKeyframesAreCheapAndHoldWhatTheyHeld) {
  Drifting robot(Exact(0.0));
  const core::Stopwatch placing;
  std::vector<std::shared_ptr<const core::PoseSource>> kept;
  std::vector<double> x_m;
  constexpr int kKeyframes = 22000;
  for (int i = 0; i < kKeyframes; ++i) {
    robot.T_map_odom_true.translation().x() = 0.001 * i;
    robot.State(0.02 * i);
    const core::AnchoredSpin spin = robot.localiser->Place(Spin(false));
    const auto poses = robot.localiser->poses();
    EXPECT_EQ(poses->latest(), spin.keyframe);
    if (i % 1000 != 0) continue;
    kept.push_back(poses);
    x_m.push_back(0.001 * i);
  }
  EXPECT_LT(placing.seconds(), 2.0);
  for (size_t k = 0; k < kept.size(); ++k) {
    EXPECT_NEAR(kept[k]->T_map_keyframe(kept[k]->latest()).translation().x(), x_m[k], 1e-9);
  }
}

TEST(Localisers, AnUnknownNameIsRefusedWithTheNearOne) {
  try {
    Drifting robot({.name = "trut"});
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'truth'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace atlas::mapping
