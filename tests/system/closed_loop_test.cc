// A short closed loop on every scene family, judged by what must hold whatever the scene.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/files.h"
#include "experiments/mission/closed_loop.h"
#include "experiments/results/run_recorder.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

class ClosedLoop : public ::testing::TestWithParam<std::string> {
 protected:
  void TearDown() override { fs::remove_all(dir_); }

  /// Three scans with few candidates and a coarse truth: minutes of simulated time in seconds.
  RunSummary Run(const std::string& experiment, int threads, const std::string& name,
                 std::vector<std::string> assignments = {}) {
    for (const char* assignment :
         {"seed=5", "mission.max_scans=3", "mission.truth_spacing_m=0.03", "planner.nodes=25"}) {
      assignments.insert(assignments.begin(), assignment);
    }
    RunOptions options;
    options.threads = threads;
    options.folder = dir_ / name;
    return RunClosedLoop(LoadExperiment(experiment, assignments), options);
  }
  fs::path dir_ = fs::temp_directory_path() / ("atlas_loop_" + std::to_string(::getpid()));
};

TEST_P(ClosedLoop, ThreeScansRaiseCoverageWithoutHarm) {
  const RunSummary summary = Run(GetParam(), 2, "run");
  EXPECT_TRUE(summary.status == RunStatus::kBudget || summary.status == RunStatus::kCompleted)
      << NameOf(summary.status) << " " << NameOf(summary.stop_reason);
  EXPECT_EQ(summary.Number("falls"), 0.0);
  EXPECT_EQ(summary.Number("collisions"), 0.0);
  const CoverageCurve curve = LoadCoverageCurve(dir_ / "run");
  ASSERT_GE(curve.coverage.size(), 2u);
  EXPECT_GT(curve.coverage.front(), 0.05);
  EXPECT_GT(curve.coverage.back(), curve.coverage.front() + 0.01);
  EXPECT_GT(summary.Number("travel_distance_m").value(), 0.5);
  EXPECT_LT(summary.Number("cloud_error_m_mean").value(), 0.03);
  for (const char* file :
       {"config.yaml", "summary.json", "steps.csv", "timings.csv", "candidates.csv", "coverage.svg",
        "cloud.ply", "ground_truth.ply", "map.atlas", "trajectory_truth.tum"}) {
    EXPECT_TRUE(fs::exists(dir_ / "run" / file)) << file;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClosedLoop,
                         ::testing::Values("helicopter", "helicopter_grating", "facade", "facade_grass",
                                           "car", "house"),
                         [](const auto& info) { return info.param; });

using Determinism = ClosedLoop;

TEST_F(Determinism, SameSeedGivesTheSameBytesWithOneOrTwoThreads) {
  Run("car", 1, "one");
  Run("car", 2, "two");
  for (const char* file : {"steps.csv", "candidates.csv", "trajectory_truth.tum", "cloud.ply", "map.atlas"}) {
    EXPECT_TRUE(core::ReadFile(dir_ / "one" / file) == core::ReadFile(dir_ / "two" / file)) << file;
  }
}

TEST_F(Determinism, SoWithOctomapWhoseMapIsItsOwnFile) {
  const RunSummary summary = Run("car", 1, "one", {"mapper=octomap"});
  Run("car", 2, "two", {"mapper=octomap"});
  EXPECT_EQ(summary.mapper, "octomap");
  EXPECT_EQ(summary.Number("falls"), 0.0);
  for (const char* file : {"steps.csv", "candidates.csv", "map.bt"}) {
    EXPECT_TRUE(core::ReadFile(dir_ / "one" / file) == core::ReadFile(dir_ / "two" / file)) << file;
  }
}

TEST_F(Determinism, KinematicLocomotionClosesTheLoopAndIsNamed) {
  const RunSummary summary = Run("car", 2, "kinematic", {"locomotion=kinematic"});
  EXPECT_EQ(summary.locomotion, "kinematic");
  EXPECT_EQ(summary.Number("scans"), 3.0);
}

}  // namespace
}  // namespace atlas::experiments
