// The words of summary and tables, spelt out by hand.
#include "experiments/identity/run_labels.h"

#include <gtest/gtest.h>

#include "tests/support/planner_stand.h"

namespace atlas::experiments {
namespace {

TEST(RunLabels, LocalisationNamesKindNoiseAndPeriod) {
  mapping::LocalisationParams p;
  p.name = "truth";
  p.sigma_m = 0.02;
  p.sigma_deg = 0.3;
  p.period_s = 2.5;
  EXPECT_EQ(LocalisationLabel(p), "truth, 20 mm 0.3 deg, 2.5 s");
  p.name = "none";
  EXPECT_EQ(LocalisationLabel(p), "none");
}

TEST(RunLabels, OdometryNamesItsWalkAndWhatIsTrue) {
  sim::OdometryParams p;
  p.drift_xy_per_m = 0.004;
  p.drift_yaw_deg_per_m = 0.25;
  EXPECT_EQ(OdometryLabel(p), "random walk, 4 mm 0.25 deg after 1 m; height, roll and pitch true");
}

TEST(RunLabels, OnlyFeetUnderPhysicsStandOnPerceivedGround) {
  sim::LocomotionParams p;
  p.terrain = "perceived";
  for (const std::string name : {"kinematic", "rail"}) {
    p.name = name;
    EXPECT_EQ(TerrainLabel(p), "truth") << name;
  }
  p.name = "trot";
  EXPECT_EQ(TerrainLabel(p), "perceived");
  p.terrain = "truth";
  EXPECT_EQ(TerrainLabel(p), "truth");
}

TEST(RunLabels, AModulatedGainSaysHowMuch) {
  const auto worth = [](tests::PlannerSettings p) {
    p.Set("gain", "occlusion_aware");
    return p.Load().own->worth();
  };
  EXPECT_EQ(worth({.name = "greedy", .values = {{"gain_share", "0.25"}}}),
            "surface_frontier x occlusion_aware (25 %)");
  EXPECT_EQ(worth({.name = "greedy", .values = {{"gain_share", "1"}}}), "");
  EXPECT_EQ(worth({.name = "thesis", .values = {}}), "");
}

}  // namespace
}  // namespace atlas::experiments
