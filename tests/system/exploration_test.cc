// A space explored while it is scored: the loop's threads share the map. Run under TSan it also shows that
// they do so without a race (`./atlas test --tsan`).
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "core/files.h"
#include "experiments/mission/closed_loop.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;

/// A room of 5 m x 4 m with a pillar.
constexpr const char* kRoom = R"yaml(
space: true
ground: {size: [8, 8]}
spawn: {x: -1.2, y: 0}
object_box: {min: [-2.6, -2.1, -0.1], max: [2.6, 2.1, 2.1]}
parts:
  - {primitive: box, size: [0.1, 4.0, 2.0], pose: {xyz: [2.5, 0, 1.0]}, name: walls}
  - {primitive: box, size: [0.1, 4.0, 2.0], pose: {xyz: [-2.5, 0, 1.0]}, name: walls}
  - {primitive: box, size: [4.8, 0.1, 2.0], pose: {xyz: [0, 1.95, 1.0]}, name: walls}
  - {primitive: box, size: [4.8, 0.1, 2.0], pose: {xyz: [0, -1.95, 1.0]}, name: walls}
  - {primitive: box, size: [0.4, 0.4, 2.0], pose: {xyz: [0.7, 0.5, 1.0]}, name: pillar}
)yaml";

class Exploration : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { core::WriteFileAtomically(dir_ / "room.yaml", kRoom); }
  void TearDown() override { fs::remove_all(dir_); }

  RunSummary Explore(int threads, const std::string& name) {
    RunOptions options;
    options.threads = threads;
    options.folder = dir_ / name;
    return RunClosedLoop(
        LoadExperiment(
            "car",
            {"seed=3", "scene=" + (dir_ / "room.yaml").string(), "mapper=" + GetParam(),
             "mapper.resolution_m=0.1", "mission.max_scans=2", "mission.truth_spacing_m=0.1",
             "locomotion=kinematic", "locomotion.sweep_period_s=3", "sensors.depth_camera=false",
             "planner.nodes=12", "planner.headings=4", "planner.rays=300", "planner.too_close_cost=false"}),
        options);
  }
  fs::path dir_ = fs::temp_directory_path() / ("atlas_room_" + std::to_string(::getpid()));
};

TEST_P(Exploration, IsScoredAndPlannedOnTwoThreadsAsOnOne) {
  const RunSummary one = Explore(1, "one"), two = Explore(2, "two");
  EXPECT_GT(two.Number("explored_of_attainable").value(), 0.5);
  EXPECT_EQ(one.Number("explored_volume_m3").value(), two.Number("explored_volume_m3").value());
  for (const char* file : {"steps.csv", "candidates.csv", "cloud.ply"}) {
    EXPECT_TRUE(core::ReadFile(dir_ / "one" / file) == core::ReadFile(dir_ / "two" / file)) << file;
  }
}

INSTANTIATE_TEST_SUITE_P(Mappers, Exploration, ::testing::Values("se_atlas", "octomap", "dense_grid"));

}  // namespace
}  // namespace atlas::experiments
