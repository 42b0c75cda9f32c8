// What the robot may know: every event, the path tracker and the gait go by where it believes to be and by
// the map that it is given, never by the true pose or the true ground.
#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "core/rng.h"
#include "locomotion_scenes.h"
#include "robots/robot_spec.h"
#include "sim/simulator.h"

namespace atlas::sim {
namespace {

using core::Pose;
using core::Vec2;
using core::Vec3;

SimParams Params(const std::string& locomotion) {
  SimParams params;
  params.locomotion.name = locomotion;
  params.sensors.depth_camera = false;
  params.sensors.walking_spin_stride = 20;
  return params;
}

std::unique_ptr<Simulator> MakeOnFlatGround(const SimParams& params, uint64_t seed) {
  return MakeSimulator(test::FlatScene(), robots::LoadRobot("quadruped"), params, core::Rng(seed));
}

/// Tells the simulator once a second where it is, with errors of its own, and hands all events on.
class NoisyFixes : public core::SensorSink {
 public:
  NoisyFixes(Simulator* sim, double sigma_m, uint64_t seed, core::SensorSink* next = nullptr)
      : sim_(sim), sigma_m_(sigma_m), rng_(seed), next_(next) {
    sim->SetSink(this);
  }
  ~NoisyFixes() override { sim_->SetSink(nullptr); }

  void OnState(const core::StateEvent& event) override {
    if (event.time_s >= next_fix_s_) {
      next_fix_s_ += 1.0;
      const Vec3 error(rng_.Normal(), rng_.Normal(), rng_.Normal());
      T_map_odom =
          Eigen::Translation3d(sigma_m_ * error) * sim_->TrueBasePose() * event.T_odom_base.inverse();
      sim_->SetLocalisation(T_map_odom);
    }
    if (next_ != nullptr) next_->OnState(event);
  }
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
    if (next_ != nullptr) next_->OnSpin(spin);
  }
  void OnDepth(const core::DepthEvent& event) override {
    if (next_ != nullptr) next_->OnDepth(event);
  }
  Pose Believed() const { return T_map_odom * sim_->T_odom_base(); }

  Pose T_map_odom = Pose::Identity();

 private:
  Simulator* sim_;
  double sigma_m_;
  core::Rng rng_;
  core::SensorSink* next_;
  double next_fix_s_ = 0.0;
};

/// A map of level ground with strips across x that are no place for a foot.
class StripedMap : public core::TerrainView {
 public:
  static constexpr double kPitchM = 0.30, kStripM = 0.12;
  static double IntoPitch(double x) { return x - kPitchM * std::floor(x / kPitchM); }
  Ground At(double x, double) const override { return {0.0, true, IntoPitch(x) >= kStripM}; }
};

/// Where feet came down, in the odometry frame.
class Landings : public core::SensorSink {
 public:
  void OnState(const core::StateEvent& event) override {
    for (int i = 0; i < 4; ++i) {
      if (event.foot_in_contact[i] && !down_[i] && event.time_s > 0.5) points.push_back(event.foot_odom[i]);
      down_[i] = event.foot_in_contact[i];
    }
  }
  int InTheMiddleOfStrips() const {
    return static_cast<int>(std::count_if(points.begin(), points.end(), [](const Vec3& p) {
      return std::abs(StripedMap::IntoPitch(p.x()) - 0.5 * StripedMap::kStripM) < 0.03;
    }));
  }
  std::vector<Vec3> points;

 private:
  bool down_[4] = {true, true, true, true};
};

/// Length of the way that odometry tells of.
class OdometryWay : public core::SensorSink {
 public:
  void OnState(const core::StateEvent& event) override {
    const Vec2 p = event.T_odom_base.translation().head<2>();
    if (p_last_) length_m += (p - *p_last_).norm();
    p_last_ = p;
  }
  double length_m = 0.0;

 private:
  std::optional<Vec2> p_last_;
};

TEST(SimulatorBelief, TheDistanceThatTheRobotKnowsIsThatOfItsOdometry) {
  SimParams params = Params("kinematic");
  params.odometry.drift_xy_per_m = 0.1;
  const auto sim = MakeOnFlatGround(params, 3);
  OdometryWay way;
  sim->SetSink(&way);
  const WalkResult walk = sim->Walk({{Vec2(5.0, 0.0)}, 0.0}, nullptr);
  sim->SetSink(nullptr);
  // Odometry that jumps to and fro tells of a longer way, and of the more the closer one looks.
  EXPECT_GT(way.length_m, 1.2 * walk.distance_m);
  EXPECT_GT(walk.odometry_distance_m, 1.15 * walk.distance_m);
  EXPECT_LT(walk.odometry_distance_m, way.length_m);
}

TEST(SimulatorBelief, FeetKeepOffWhatTheMapHoldsUnsteppableThoughTheGroundIsLevel) {
  const StripedMap map;
  const auto landings_with = [&](const std::string& terrain) {
    SimParams params = Params("trot");
    params.locomotion.terrain = terrain;
    params.odometry.drift_xy_per_m = params.odometry.drift_yaw_deg_per_m = 0.0;
    const auto sim = MakeOnFlatGround(params, 2);
    Landings landings;
    sim->SetSink(&landings);
    EXPECT_EQ(sim->Walk({{Vec2(4.0, 0.0)}, 0.0}, &map).status, MotionStatus::kReached);
    sim->SetSink(nullptr);
    return landings;
  };
  const Landings perceived = landings_with("perceived"), truth = landings_with("truth");
  EXPECT_GT(perceived.points.size(), 40u);
  EXPECT_GT(truth.InTheMiddleOfStrips(), 8) << "on true heights, strips mean nothing";
  EXPECT_LT(3 * perceived.InTheMiddleOfStrips(), truth.InTheMiddleOfStrips());
}

/// Level ground; keeps how far from the robot it was asked.
class AskedMap : public core::TerrainView {
 public:
  explicit AskedMap(const Simulator* sim) : sim_(sim) {}
  Ground At(double x, double y) const override {
    ++asked;
    from_odometry_m2 += (Vec2(x, y) - sim_->T_odom_base().translation().head<2>()).squaredNorm();
    from_true_m2 += (Vec2(x, y) - sim_->TrueBasePose().translation().head<2>()).squaredNorm();
    return {0.0, true, true};
  }
  mutable double asked = 0.0, from_odometry_m2 = 0.0, from_true_m2 = 0.0;

 private:
  const Simulator* sim_;
};

TEST(SimulatorBelief, TheGaitReadsTheMapWhereOdometryHasTheRobot) {
  SimParams params = Params("trot");
  params.odometry.drift_xy_per_m = 0.2;
  const auto sim = MakeOnFlatGround(params, 3);
  const AskedMap map(sim.get());
  sim->Walk({{Vec2(4.0, 0.0)}, 0.0}, &map);
  ASSERT_GT(map.asked, 1000.0);
  EXPECT_GT((sim->T_odom_base().translation() - sim->TrueBasePose().translation()).norm(), 0.15);
  EXPECT_LT(map.from_odometry_m2 / map.asked, map.from_true_m2 / map.asked - 0.01);
}

/// What the gait asks of level ground, walking on while the localisation jumps.
std::vector<Vec2> AskedUnderJumpsOf(double sigma_m) {
  struct Level : core::TerrainView {
    explicit Level(const Simulator* s) : sim(s) {}
    Ground At(double x, double y) const override {
      offsets.push_back(Vec2(x, y) - sim->TrueBasePose().translation().head<2>());
      return {0.0, true, true};
    }
    const Simulator* sim;
    mutable std::vector<Vec2> offsets;
  };
  SimParams params = Params("trot");
  params.odometry.drift_xy_per_m = params.odometry.drift_yaw_deg_per_m = 0.0;
  const auto sim = MakeOnFlatGround(params, 5);
  const NoisyFixes fixes(sim.get(), sigma_m, 5);
  const Level map(sim.get());
  EXPECT_EQ(sim->Walk({{Vec2(3.0, 0.0)}, 0.0}, &map).status, MotionStatus::kReached);
  EXPECT_LT(sim->safety().worst_foot_drop_m, 0.03) << sigma_m;
  EXPECT_EQ(sim->safety().falls, 0);
  return map.offsets;
}

TEST(SimulatorBelief, AJumpOfTheLocalisationMovesNoGroundUnderTheFeet) {
  const auto farthest = [](double sigma_m) {
    double most = 0.0;
    for (const Vec2& offset : AskedUnderJumpsOf(sigma_m)) most = std::max(most, offset.norm());
    return most;
  };
  // Hips, steps and search reach as far from the robot as ever, however it is localised.
  EXPECT_LT(farthest(0.1), farthest(0.0) + 0.05);
}

TEST(SimulatorBelief, PathsAreFollowedByBelievedPoses) {
  constexpr double kSigma = 0.10;
  constexpr int kRuns = 12;
  double error2 = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const auto sim = MakeOnFlatGround(Params("kinematic"), static_cast<uint64_t>(run));
    const NoisyFixes fixes(sim.get(), kSigma, static_cast<uint64_t>(run));
    sim->Walk({{Vec2(1.0, 0.0)}, 0.0}, nullptr);
    error2 += (sim->TrueBasePose().translation().head<2>() - Vec2(1.0, 0.0)).squaredNorm();
  }
  // It stops where it believes to have arrived, within 5 cm: the true place is off by most of the error.
  EXPECT_GT(std::sqrt(error2 / kRuns), 0.6 * kSigma);
}

/// Holds every event against the simulator's own estimates at that moment.
class Comparer : public core::SensorSink {
 public:
  explicit Comparer(const Simulator* sim, const robots::RobotSpec& robot) : sim_(sim), robot_(robot) {}

  void Remember() { T_odom_base_at_[std::lround(1e3 * sim_->time_s())] = sim_->T_odom_base(); }

  void OnState(const core::StateEvent& event) override {
    ++states;
    EXPECT_EQ(event.T_odom_base.matrix(), sim_->T_odom_base().matrix());
    const Pose T_map_base = sim_->TrueBasePose();
    error_m2 += (event.T_odom_base.translation() - T_map_base.translation()).squaredNorm();
    const Pose T_map_odom_true = T_map_base * event.T_odom_base.inverse();
    for (int i = 0; i < 4; ++i) {
      // Joints tell where the feet are about the base, exactly: soles in contact lie on the true floor.
      if (!event.foot_in_contact[i]) continue;
      EXPECT_NEAR((T_map_odom_true * event.foot_odom[i]).z(), 0.0, 1e-9);
    }
  }
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
    for (const core::StampedPose& pose : spin->T_odom_lidar.poses()) {
      const auto at = T_odom_base_at_.find(std::lround(1e3 * pose.time_s));
      if (at == T_odom_base_at_.end()) continue;
      ++spin_poses;
      EXPECT_LT((pose.T.matrix() - (at->second * robot_.T_base_lidar).matrix()).norm(), 1e-9);
    }
  }
  void OnDepth(const core::DepthEvent& event) override {
    ++depths;
    const Pose expected = sim_->T_odom_base() * robot_.T_base_depth;
    EXPECT_LT((event.T_odom_camera.matrix() - expected.matrix()).norm(), 1e-9);
  }
  int states = 0, spin_poses = 0, depths = 0;
  double error_m2 = 0.0;

 private:
  const Simulator* sim_;
  const robots::RobotSpec& robot_;
  std::map<long, Pose> T_odom_base_at_;  ///< by milliseconds
};

TEST(SimulatorBelief, EventsCarryEstimatesAndNoTruth) {
  SimParams params = Params("kinematic");
  params.sensors.depth_camera = true;
  params.sensors.walking_spin_stride = 4;
  params.odometry.drift_xy_per_m = 0.15;
  params.odometry.drift_yaw_deg_per_m = 2.0;
  const robots::RobotSpec robot = robots::LoadRobot("quadruped");
  const auto sim = MakeOnFlatGround(params, 6);
  Comparer comparer(sim.get(), robot);
  sim->SetSink(&comparer);
  sim->AddStateObserver([&](const Snapshot&) { comparer.Remember(); }, 200.0);
  sim->Walk({{Vec2(2.0, 0.0), Vec2(2.0, 1.0)}, 0.0}, nullptr);
  EXPECT_GT(comparer.states, 200);
  EXPECT_GT(comparer.spin_poses, 200);
  if (sim->render_backend() != "none") {
    EXPECT_GT(comparer.depths, 5);
  }
  EXPECT_GT(std::sqrt(comparer.error_m2 / comparer.states), 0.05) << "odometry and truth are apart";
}

TEST(SimulatorBelief, TheSweepRollsToItsAngleBothWaysInItsPeriod) {
  for (const double roll_deg : {40.0, 25.0}) {
    SimParams params = Params("kinematic");
    params.locomotion.sweep_roll_deg = roll_deg;
    params.locomotion.sweep_period_s = 5.0;
    const auto sim = MakeOnFlatGround(params, 1);
    double low = 0.0, high = 0.0;
    sim->AddStateObserver(
        [&](const Snapshot&) {
          const core::Mat3 R = sim->TrueBasePose().linear();
          const double roll = std::atan2(R(2, 1), R(2, 2));
          low = std::min(low, roll);
          high = std::max(high, roll);
        },
        100.0);
    const double start_s = sim->time_s();
    EXPECT_EQ(sim->RollSweep(), MotionStatus::kReached);
    EXPECT_NEAR(core::Degrees(high), roll_deg, 0.5);
    EXPECT_NEAR(core::Degrees(low), -roll_deg, 0.5);
    EXPECT_NEAR(sim->time_s() - start_s, 5.0, 0.3);
  }
}

}  // namespace
}  // namespace atlas::sim
