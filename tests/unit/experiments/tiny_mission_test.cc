// Whole missions, tiny ones: what the robot does follows from what it may know, not from what is true.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/support/csv_rows.h"
#include "tests/support/tiny_mission.h"

namespace atlas::experiments {
namespace {

using core::Vec2;
using core::Vec3;

/// The true position nearest to a time, of trajectory_truth.tum.
Vec3 TrueAt(const std::string& tum, double time_s) {
  std::istringstream in(tum);
  Vec3 nearest = Vec3::Zero();
  double best = 1e9;
  for (double t, x, y, z, qx, qy, qz, qw; in >> t >> x >> y >> z >> qx >> qy >> qz >> qw;) {
    if (std::abs(t - time_s) >= best) continue;
    best = std::abs(t - time_s);
    nearest = {x, y, z};
  }
  return nearest;
}

/// How far each step's pose lies from the true one.
std::vector<double> PoseErrors(const tests::TinyMissions& missions, const std::string& name) {
  std::vector<double> errors;
  const std::string tum = missions.FileOf(name, "trajectory_truth.tum");
  for (const tests::CsvRow& row : tests::ReadCsvText(missions.FileOf(name, "steps.csv"))) {
    const Vec3 believed(std::stod(row.at("x_m")), std::stod(row.at("y_m")), std::stod(row.at("z_m")));
    errors.push_back((believed - TrueAt(tum, std::stod(row.at("sim_time_s")))).norm());
  }
  return errors;
}

TEST(TinyMission, ThePoseOfAStepIsWhatTheRobotBelieves) {
  const tests::TinyMissions missions;
  missions.Run({"localisation.sigma_m=0.15", "mission.max_scans=3"}, "lost");
  missions.Run({"localisation.sigma_m=0", "localisation.sigma_deg=0"}, "sure");
  const std::vector<double> lost = PoseErrors(missions, "lost"), sure = PoseErrors(missions, "sure");
  ASSERT_GE(lost.size(), 2u);
  double most = 0.0;
  for (const double error : lost) most = std::max(most, error);
  EXPECT_GT(most, 0.10) << "it cannot know better than its localisation";
  for (const double error : sure) EXPECT_LT(error, 0.02);
}

TEST(TinyMission, TheGaitWalksOnThePerceivedMap) {
  const tests::TinyMissions missions;
  for (const std::string terrain : {"perceived", "truth"}) {
    missions.Run({"locomotion.name=trot", "locomotion.speed_mps=0.5", "locomotion.terrain=" + terrain},
                 terrain);
  }
  EXPECT_NE(missions.FileOf("perceived", "trajectory_truth.tum"),
            missions.FileOf("truth", "trajectory_truth.tum"))
      << "a perceived map is never as even as the true floor";
}

TEST(TinyMission, TimesAreSecondsOfItsOwnWallClock) {
  const tests::TinyMissions missions;
  const RunSummary summary = missions.Run({}, "timed");
  double before = 0.0;
  for (const tests::CsvRow& row : tests::ReadCsvText(missions.FileOf("timed", "timings.csv"))) {
    const double wall = std::stod(row.at("wall_time_s"));
    const double nbv = std::stod(row.at("nbv_time_s")), sweep = std::stod(row.at("sweep_wall_s")),
                 walk = std::stod(row.at("walk_wall_s"));
    EXPECT_GT(nbv, 1e-5);
    EXPECT_GT(sweep, 1e-3);
    EXPECT_LE(nbv + sweep + walk, wall - before + 1e-3);
    before = wall;
  }
  EXPECT_GT(before, 0.0);
  EXPECT_LE(before, summary.Number("wall_time_s").value() + 1e-3);
}

TEST(TinyMission, AnotherSeedIsAnotherRun) {
  const tests::TinyMissions missions;
  missions.Run({"mission.max_scans=1", "seed=3"}, "three");
  missions.Run({"mission.max_scans=1", "seed=4"}, "four");
  for (const char* file : {"cloud.ply", "map.atlas"}) {
    EXPECT_TRUE(missions.FileOf("three", file) != missions.FileOf("four", file)) << file;
  }
}

/// What the robot did and decided: everything but what it is judged by.
std::string Decisions(const tests::TinyMissions& missions, const std::string& name) {
  std::string text = missions.FileOf(name, "candidates.csv") + missions.FileOf(name, "trajectory_odom.tum");
  for (const tests::CsvRow& row : tests::ReadCsvText(missions.FileOf(name, "steps.csv"))) {
    for (const auto& [column, cell] : row) {
      const bool judged =
          column.starts_with("coverage") || column.starts_with("cloud_error") || column == "flat_by_truth";
      if (!judged) text += column + "=" + cell + " ";
    }
  }
  return text;
}

TEST(TinyMission, NothingIsDecidedByTheScore) {
  const tests::TinyMissions missions;
  std::vector<RunSummary> summaries;
  int number = 0;
  for (const std::string judged :
       {"mission.coverage_radius_m=0.043", "mission.coverage_radius_m=0.4", "mission.truth_spacing_m=0.1"}) {
    summaries.push_back(
        missions.Run({"mission.max_scans=12", "planner.stop_rounds=2", "planner.flat_rounds=2", judged},
                     std::to_string(number++)));
  }
  EXPECT_GT(*summaries[1].Number("coverage"), *summaries[0].Number("coverage") + 0.02) << "the judges differ";
  for (int other : {1, 2}) {
    EXPECT_EQ(Decisions(missions, "0"), Decisions(missions, std::to_string(other)));
    EXPECT_EQ(summaries[0].status, summaries[static_cast<size_t>(other)].status);
    EXPECT_EQ(summaries[0].stop_reason, summaries[static_cast<size_t>(other)].stop_reason);
  }
}

}  // namespace
}  // namespace atlas::experiments
