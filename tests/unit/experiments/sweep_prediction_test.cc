// What the planner expects of a sweep against the revolutions that the simulator's LiDAR casts.
#include <gtest/gtest.h>

#include <array>

#include "planner/gain/sweep_view.h"
#include "robots/robot_spec.h"
#include "sim/simulator.h"
#include "tests/support/small_scenes.h"

namespace atlas::experiments {
namespace {

using core::Degrees;
using core::Radians;
using core::Vec3;

constexpr int kBand_deg = 10, kColumns = 360 / kBand_deg, kRows = 180 / kBand_deg;
/// Rays by direction from the LiDAR in the levelled base frame: elevation by azimuth from the nose.
using Sphere = std::array<std::array<double, kColumns>, kRows>;

/// Casts nothing away: a ray counts where it goes, whatever it meets.
class RayCounter : public core::SensorSink {
 public:
  void OnSpin(const std::shared_ptr<const core::SpinEvent>& spin) override {
    const core::SpinEvent& event = *spin;
    if (!event.scanning) return;
    for (size_t i = 0; i < event.scan.size(); ++i) {
      const core::Pose T =
          event.T_odom_lidar.At(event.scan.stamp_s + static_cast<double>(event.scan.time_s[i]));
      const Vec3 d = T.linear() * event.scan.direction_lidar[i].cast<double>();
      const double azimuth_deg = Degrees(std::atan2(d.y(), d.x())), elevation_deg = Degrees(std::asin(d.z()));
      const auto column =
          static_cast<size_t>(std::clamp((azimuth_deg + 180.0) / kBand_deg, 0.0, kColumns - 1.0));
      const auto row = static_cast<size_t>(std::clamp((elevation_deg + 90.0) / kBand_deg, 0.0, kRows - 1.0));
      rays[row][column] += 1.0;
    }
  }
  Sphere rays = {};
};

Sphere Simulated(const sim::SimParams& params) {
  RayCounter counter;
  const auto simulator =
      sim::MakeSimulator(tests::OpenFloor(), robots::LoadRobot("quadruped"), params, core::Rng(3));
  simulator->SetSink(&counter);
  EXPECT_EQ(simulator->RollSweep(), sim::MotionStatus::kReached);
  return counter.rays;
}

Sphere Predicted(const sim::SimParams& params) {
  const robots::RobotSpec robot = robots::LoadRobot("quadruped");
  const planner::SweepView view(
      {.lidar = core::FindLidarModel(robot.lidar_model),
       .T_base_lidar = robot.T_base_lidar,
       .base_height_m = robot.stance_height_m,
       .roll = {Radians(params.locomotion.sweep_roll_deg), params.locomotion.sweep_period_s}});
  Sphere rays = {};
  constexpr int kFine = 4;  // a degree
  for (int e = 0; e < 180 * kFine; ++e) {
    for (int a = 0; a < 360 * kFine; ++a) {
      const double elevation = Radians((e + 0.5) / kFine - 90.0),
                   azimuth = Radians((a + 0.5) / kFine - 180.0);
      const double solid_angle = Radians(1.0 / kFine) * Radians(1.0 / kFine) * std::cos(elevation);
      rays[static_cast<size_t>(e / kFine / kBand_deg)][static_cast<size_t>(a / kFine / kBand_deg)] +=
          solid_angle * view.RaysPerSteradian(azimuth, elevation);
    }
  }
  return rays;
}

/// Rays between these elevations within 20 degrees of abeam, both sides, up and down.
double Abeam(const Sphere& rays, int low_deg, int high_deg) {
  double sum = 0.0;
  for (int band = low_deg / kBand_deg; band < high_deg / kBand_deg; ++band) {
    for (const int row : {kRows / 2 + band, kRows / 2 - 1 - band}) {
      for (const int column : {7, 8, 9, 10, 25, 26, 27, 28}) {
        sum += rays[static_cast<size_t>(row)][static_cast<size_t>(column)];
      }
    }
  }
  return sum;
}

void ExpectPredicted(const sim::SimParams& params, double tolerance) {
  const Sphere simulated = Simulated(params), predicted = Predicted(params);
  double all_simulated = 0.0, all_predicted = 0.0;
  for (size_t row = 0; row < kRows; ++row) {
    for (size_t column = 0; column < kColumns; ++column) {
      all_simulated += simulated[row][column];
      all_predicted += predicted[row][column];
    }
  }
  EXPECT_NEAR(all_predicted, all_simulated, 0.02 * all_simulated);
  for (size_t row = 0; row < kRows; ++row) {
    for (size_t column = 0; column < kColumns; ++column) {
      EXPECT_NEAR(predicted[row][column], simulated[row][column],
                  tolerance * simulated[row][column] + 0.0006 * all_simulated)
          << "elevation from " << static_cast<int>(row) * kBand_deg - 90 << ", azimuth from "
          << static_cast<int>(column) * kBand_deg - 180;
    }
  }
  for (const int low : {0, 10, 20, 30, 40}) {
    EXPECT_NEAR(Abeam(predicted, low, low + 10) / Abeam(simulated, low, low + 10), 1.0, tolerance)
        << "abeam, elevation from " << low;
  }
  // The beams end within this band, where a degree of roll more or less counts most.
  EXPECT_NEAR(Abeam(predicted, 50, 60) / Abeam(simulated, 50, 60), 1.0, 0.2) << "abeam, elevation from 50";
}

sim::SimParams Params(const std::string& locomotion) {
  sim::SimParams params;
  params.locomotion.name = locomotion;
  params.sensors.depth_camera = false;
  return params;
}

TEST(SweepPrediction, EqualsTheRaysThatTheSimulatedSweepCasts) {
  ExpectPredicted(Params("kinematic"), 0.1);
}

TEST(SweepPrediction, EqualsThoseOfTheRobotThatStandsOnItsLegs) {
  ExpectPredicted(Params("trot"), 0.1);
}

TEST(SweepPrediction, FollowsThePeriodAndTheRollOfTheSweep) {
  sim::SimParams params = Params("kinematic");
  params.locomotion.sweep_period_s = 12.0;
  params.locomotion.sweep_roll_deg = 20.0;
  const Sphere simulated = Simulated(params), predicted = Predicted(params);
  EXPECT_NEAR(Abeam(predicted, 0, 40) / Abeam(simulated, 0, 40), 1.0, 0.03);
  EXPECT_NEAR(Abeam(predicted, 20, 30) / Abeam(simulated, 20, 30), 1.0, 0.1);
  EXPECT_EQ(Abeam(predicted, 40, 60), 0.0);
}

}  // namespace
}  // namespace atlas::experiments
