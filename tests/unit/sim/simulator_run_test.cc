#include <gtest/gtest.h>

#include <fstream>

#include "core/errors.h"
#include "core/files.h"
#include "locomotion_scenes.h"
#include "robots/robot_spec.h"
#include "sim/simulator.h"

namespace atlas::sim {
namespace {

using core::Vec2;

SimParams FastParams() {
  SimParams params;
  params.sensors.depth_camera = false;
  params.locomotion.sweep_period_s = 4.0;
  return params;
}

scenes::SceneSpec SceneWithPillar() {
  scenes::SceneSpec scene = test::FlatScene();
  scene.parts.push_back(test::BoxPart("pillar", {0.3, 0.3, 1.0}, test::At(2.0, 3.0, 1.0)));
  scene.T_map_spawn = core::PoseFromXyzYaw({1.0, -0.5, 0.0}, 0.4);
  return scene;
}

std::unique_ptr<Simulator> Make(const SimParams& params, uint64_t seed = 1) {
  return MakeSimulator(SceneWithPillar(), robots::LoadRobot("quadruped"), params, core::Rng(seed));
}

/// Keeps what came and checks that times never fall.
class Recorder : public core::SensorSink {
 public:
  void OnState(const core::StateEvent& event) override {
    EXPECT_GE(event.time_s, last_s);
    last_s = event.time_s;
    states.push_back(event);
  }
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
    EXPECT_GE(spin->scan.stamp_s, last_spin_s);
    last_spin_s = spin->scan.stamp_s;
    spins.push_back(*spin);
  }
  /// The revolutions of the scanning action.
  std::vector<core::SpinEvent> Sweep() const {
    std::vector<core::SpinEvent> sweep;
    for (const core::SpinEvent& spin : spins) {
      if (spin.scanning) sweep.push_back(spin);
    }
    return sweep;
  }
  double last_s = -1.0, last_spin_s = -1.0;
  std::vector<core::StateEvent> states;
  std::vector<core::SpinEvent> spins;
};

void Mission(Simulator* sim, Recorder* recorder) {
  sim->SetSink(recorder);
  EXPECT_EQ(sim->Stand(0.5), MotionStatus::kReached);
  const WalkResult walk = sim->Walk({{Vec2(2.0, -0.5), Vec2(2.0, 0.5)}, 0.0}, nullptr);
  EXPECT_EQ(walk.status, MotionStatus::kReached);
  EXPECT_NEAR(walk.distance_m, 2.0, 0.4);
  EXPECT_EQ(sim->RollSweep(), MotionStatus::kReached);
}

TEST(Simulator, EventsComeInOrderAtTheirRates) {
  for (const char* locomotion : {"trot", "kinematic"}) {
    SimParams params = FastParams();
    params.locomotion.name = locomotion;
    const auto sim = Make(params);
    Recorder recorder;
    Mission(sim.get(), &recorder);
    const std::vector<core::SpinEvent> sweep = recorder.Sweep();
    EXPECT_NEAR(static_cast<double>(recorder.states.size()), 50.0 * sim->time_s(), 3.0) << locomotion;
    ASSERT_EQ(sweep.size(), 40u) << locomotion;
    for (size_t i = 1; i < sweep.size(); ++i) {
      EXPECT_NEAR(sweep[i].scan.stamp_s - sweep[i - 1].scan.stamp_s, 0.1, 0.003);
    }
    for (const core::SpinEvent& spin : recorder.spins) {
      const auto& poses = spin.T_odom_lidar.poses();
      EXPECT_NEAR(poses.front().time_s, spin.scan.stamp_s, 1e-6);
      EXPECT_NEAR(poses.back().time_s, spin.scan.stamp_s + 0.1, 0.006);
      EXPECT_GE(poses.size(), 20u);
    }
    const double walked_s = sim->time_s() - 4.0;
    EXPECT_NEAR(static_cast<double>(recorder.spins.size()), 40.0 + walked_s * 10.0 / 2.0, 3.0);
  }
}

TEST(Simulator, BelievedScanMatchesTheScene) {
  const auto sim = Make(FastParams());
  const core::Pose T_map_odom = SceneWithPillar().T_map_spawn;
  Recorder recorder;
  Mission(sim.get(), &recorder);
  size_t hits = 0, near = 0, pillar = 0;
  for (const core::SpinEvent& spin : recorder.Sweep()) {
    for (size_t i = 0; i < spin.scan.size(); ++i) {
      if (spin.scan.kind[i] != core::ReturnKind::kHit || spin.scan.range_m[i] > 6.0f) continue;
      const core::Pose T = T_map_odom * spin.T_odom_lidar.At(spin.scan.stamp_s + spin.scan.time_s[i]);
      const core::Vec3 p = T * (spin.scan.direction_lidar[i] * spin.scan.range_m[i]).cast<double>();
      const core::Vec3 q = (p - core::Vec3(2.0, 3.0, 1.0)).cwiseAbs() - core::Vec3(0.3, 0.3, 1.0);
      const bool on_pillar = std::abs(q.maxCoeff()) < 0.06;
      ++hits;
      pillar += on_pillar;
      near += on_pillar || std::abs(p.z()) < 0.06;
    }
  }
  EXPECT_GT(hits, 50000u);
  EXPECT_GT(pillar, 2000u);
  EXPECT_GT(static_cast<double>(near), 0.999 * static_cast<double>(hits));
}

TEST(Simulator, SameSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  std::vector<double> qpos[2];
  std::vector<float> ranges[2];
  core::Pose T_odom[2];
  for (int run = 0; run < 2; ++run) {
    SimParams params = FastParams();
    params.sensors.threads = 1 + 2 * run;
    const auto sim = Make(params, 9);
    Recorder recorder;
    Mission(sim.get(), &recorder);
    qpos[run] = sim->TrueState().qpos;
    T_odom[run] = sim->T_odom_base();
    for (const core::SpinEvent& spin : recorder.spins) {
      ranges[run].insert(ranges[run].end(), spin.scan.range_m.begin(), spin.scan.range_m.end());
    }
  }
  EXPECT_EQ(qpos[0], qpos[1]);
  EXPECT_EQ(ranges[0], ranges[1]);
  EXPECT_EQ(T_odom[0].matrix(), T_odom[1].matrix());
}

TEST(Simulator, AnotherSeedWalksAnotherWay) {
  const auto a = Make(FastParams(), 1), b = Make(FastParams(), 2);
  a->Stand(0.5);
  b->Stand(0.5);
  EXPECT_NE(a->TrueState().qpos, b->TrueState().qpos);
}

TEST(Simulator, OdometryDriftsByItsRandomWalk) {
  double squared = 0.0;
  constexpr int kRuns = 40;
  for (int run = 0; run < kRuns; ++run) {
    SimParams params = FastParams();
    params.locomotion.name = "kinematic";
    params.locomotion.speed_mps = 1.0;
    params.odometry.drift_xy_per_m = 0.05;
    params.odometry.drift_yaw_deg_per_m = 0.0;
    const auto sim = MakeSimulator(test::FlatScene(), robots::LoadRobot("quadruped"), params,
                                   core::Rng(static_cast<uint64_t>(run)));
    sim->Walk({{Vec2(9.0, 0.0)}, 0.0}, nullptr);
    const core::Vec3 truth = sim->TrueBasePose().translation();
    squared += (sim->T_odom_base().translation() - truth).head<2>().squaredNorm();
  }
  // Two axes of standard deviation 0.05 sqrt(9); 80 squared normals lie within 0.55 and 1.6 of their mean.
  EXPECT_GT(squared / kRuns, 0.55 * 2.0 * 0.0025 * 9.0);
  EXPECT_LT(squared / kRuns, 1.6 * 2.0 * 0.0025 * 9.0);
}

TEST(Simulator, StopsWithinFiftyMillisecondsOfBeingAsked) {
  const auto sim = Make(FastParams());
  double asked_s = -1.0;
  sim->SetStop([&] {
    if (sim->time_s() > 2.0 && asked_s < 0.0) asked_s = sim->time_s();
    return asked_s >= 0.0;
  });
  EXPECT_EQ(sim->Walk({{Vec2(8.0, -0.5)}, 0.0}, nullptr).status, MotionStatus::kStopped);
  EXPECT_LT(sim->time_s(), 2.05);
  EXPECT_EQ(sim->RollSweep(), MotionStatus::kStopped);
}

TEST(Simulator, AWalkAgainstAWallGetsStuck) {
  scenes::SceneSpec scene = test::FlatScene();
  scene.parts.push_back(test::BoxPart("wall", {0.1, 3.0, 1.0}, test::At(1.5, 0.0, 1.0)));
  const auto sim = MakeSimulator(scene, robots::LoadRobot("quadruped"), FastParams(), core::Rng(1));
  const WalkResult walk = sim->Walk({{Vec2(4.0, 0.0)}, 0.0}, nullptr);
  EXPECT_EQ(walk.status, MotionStatus::kStuck);
  EXPECT_LT(walk.duration_s, 20.0);
  EXPECT_GE(sim->safety().collisions, 1);
}

TEST(Simulator, FollowsItsPathWithinTenCentimetres) {
  const std::vector<Vec2> path = {{3.0, 0.0}, {3.0, 2.0}, {1.0, 2.5}};
  SimParams params = FastParams();
  const auto sim = MakeSimulator(test::FlatScene(), robots::LoadRobot("quadruped"), params, core::Rng(4));
  double farthest = 0.0;
  sim->AddStateObserver(
      [&](const Snapshot& snapshot) {
        const Vec2 p(snapshot.qpos[0], snapshot.qpos[1]);
        double nearest = 1e9;
        Vec2 from = Vec2::Zero();
        for (const Vec2& to : path) {
          const Vec2 way = to - from;
          const double u = std::clamp((p - from).dot(way) / way.squaredNorm(), 0.0, 1.0);
          nearest = std::min(nearest, (p - from - u * way).norm());
          from = to;
        }
        farthest = std::max(farthest, nearest);
      },
      20.0);
  const WalkResult walk = sim->Walk({path, 1.0}, nullptr);
  EXPECT_EQ(walk.status, MotionStatus::kReached);
  EXPECT_LT(farthest, 0.12);
  EXPECT_LT((sim->TrueBasePose().translation().head<2>() - path.back()).norm(), 0.08);
  EXPECT_NEAR(core::YawOf(sim->TrueBasePose().linear()), 1.0, 0.08);
}

TEST(Simulator, BadInputIsOneLineThatNamesIt) {
  const auto message = [](const std::function<void()>& call) -> std::string {
    try {
      call();
    } catch (const core::InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(message([] { robots::LoadRobot("quadrupod"); }).find("quadruped"), std::string::npos);
  EXPECT_NE(message([] { robots::LoadRobot("/nowhere/robot.xml"); }).find("/nowhere/robot.xml"),
            std::string::npos);

  const auto folder = std::filesystem::temp_directory_path() / "atlas_robot_test";
  std::string xml = core::ReadFile(core::InstalledFile("robots/quadruped.xml"));
  const auto with = [&](const std::string& from, const std::string& to, const std::string& name) {
    std::string changed = xml;
    changed.replace(changed.find(from), from.size(), to);
    core::WriteFileAtomically(folder / name, changed);
    return (folder / name).string();
  };
  const std::string malformed = with("<worldbody>", "<worldbody", "malformed.xml");
  EXPECT_NE(message([&] { robots::LoadRobot(malformed); }).find("malformed"), std::string::npos);
  const std::string no_joint = with("joint name=\"RH_HFE\"", "joint name=\"RH_XXX\"", "no_joint.xml");
  EXPECT_NE(message([&] { robots::LoadRobot(no_joint); }).find("RH_HFE"), std::string::npos);
  const std::string bad_geom =
      with("type=\"box\" size=\"0.2655", "type=\"blob\" size=\"0.2655", "bad_geom.xml");
  const std::string text = message(
      [&] { MakeSimulator(test::FlatScene(), robots::LoadRobot(bad_geom), FastParams(), core::Rng(1)); });
  EXPECT_NE(text.find("bad_geom.xml"), std::string::npos);
  EXPECT_EQ(text.find('\n'), std::string::npos);
  SimParams params = FastParams();
  params.locomotion.name = "trott";
  EXPECT_NE(message([&] { Make(params); }).find("trot"), std::string::npos);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace atlas::sim
