// Runs that differ in nothing but what they sense: the true path on rails, and the range noise that is asked
// for.
#include <gtest/gtest.h>

#include "locomotion_scenes.h"
#include "robots/robot_spec.h"
#include "sim/simulator.h"

namespace atlas::sim {
namespace {

using core::Vec2;

/// Ranges of hits, 0 elsewhere, spin after spin.
class Ranges : public core::SensorSink {
 public:
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
    range_m.insert(range_m.end(), spin->scan.range_m.begin(), spin->scan.range_m.end());
  }
  std::vector<float> range_m;
};

struct Ride {
  std::vector<double> path;  ///< of the true base: x, y, z, and the rotation's first column
  std::vector<float> range_m;
};

Ride RideWith(const std::string& locomotion, double drift, double range_sigma_m) {
  SimParams params;
  params.locomotion.name = locomotion;
  params.odometry.drift_xy_per_m = drift;
  params.odometry.drift_yaw_deg_per_m = 10.0 * drift;
  params.sensors.depth_camera = false;
  params.sensors.range_sigma_m = range_sigma_m;
  const auto sim = MakeSimulator(test::FlatScene(), robots::LoadRobot("quadruped"), params, core::Rng(4));
  Ranges ranges;
  sim->SetSink(&ranges);
  Ride ride;
  sim->AddStateObserver(
      [&](const Snapshot&) {
        const core::Pose T = sim->TrueBasePose();
        for (const double v : {T(0, 3), T(1, 3), T(2, 3), T(0, 0), T(1, 0), T(2, 0)}) ride.path.push_back(v);
      },
      20.0);
  EXPECT_EQ(sim->Walk({{Vec2(0, 0), Vec2(1.5, 0.0), Vec2(1.5, 1.0)}, 1.0}, nullptr).status,
            MotionStatus::kReached);
  EXPECT_EQ(sim->RollSweep(), MotionStatus::kReached);
  ride.range_m = std::move(ranges.range_m);
  return ride;
}

TEST(Rail, TheTruePathIsTheSameWhateverTheRobotBelieves) {
  EXPECT_EQ(RideWith("rail", 0.0, 0.0).path, RideWith("rail", 0.2, 0.03).path);
  EXPECT_NE(RideWith("kinematic", 0.0, 0.0).path, RideWith("kinematic", 0.2, 0.03).path);
}

TEST(Rail, RangesErrByTheSigmaThatIsAskedFor) {
  const Ride exact = RideWith("rail", 0.0, 0.0), noisy = RideWith("rail", 0.0, 0.03);
  ASSERT_EQ(exact.range_m.size(), noisy.range_m.size());
  double sum_sq = 0.0, count = 0.0;
  for (size_t i = 0; i < exact.range_m.size(); ++i) {
    if (exact.range_m[i] <= 1.0f || noisy.range_m[i] <= 1.0f) continue;
    sum_sq += std::pow(noisy.range_m[i] - exact.range_m[i], 2.0);
    ++count;
  }
  ASSERT_GT(count, 10000.0);
  EXPECT_NEAR(std::sqrt(sum_sq / count), 0.03, 0.001);  // draws end at three sigmas
}

}  // namespace
}  // namespace atlas::sim
