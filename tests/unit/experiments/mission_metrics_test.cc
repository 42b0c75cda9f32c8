// What a mission is judged by, fed by hand: clouds whose coverage is known, counts that must reach their
// columns.
#include "experiments/judge/mission_metrics.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

#include "mapping/slam/fixed_poses.h"
#include "robots/robot_spec.h"
#include "scenes/catalog.h"
#include "tests/support/csv_rows.h"
#include "tests/support/fake_simulator.h"

namespace atlas::experiments {
namespace {

namespace fs = std::filesystem;
using core::Vec3f;

/// A block of a metre on flat ground, whose top no sweep sees.
constexpr const char* kBlockScene = R"(
spawn: {x: -3.0, y: 0.0}
ground: {size: [8, 8]}
object_box: {min: [-0.6, -0.6, 0.05], max: [0.6, 0.6, 1.6]}
parts:
  - {primitive: box, name: block, size: [1.0, 1.0, 1.4], pose: {xyz: [0, 0, 0.7]}}
)";

class SilentMap : public mapping::Map {
 public:
  void Integrate(const core::AnchoredSpin&, const core::PoseSource&) override {}
  std::shared_ptr<const mapping::MapView> Snapshot() const override { return nullptr; }
  size_t Bytes() const override { return 4711; }
  std::string Save(const fs::path&) const override { return {}; }
};

class MissionMetricsTest : public ::testing::Test {
 protected:
  MissionMetricsTest() {
    core::WriteFileAtomically(folder_ / "block.yaml", kBlockScene);
    ::setenv("ATLAS_CACHE", (fs::temp_directory_path() / "atlas_test_cache").c_str(), 1);
    config_.experiment = "block";
    config_.scene.name = (folder_ / "block.yaml").string();
    config_.mission.truth_spacing_m = 0.04;
    scene_ = scenes::LoadScene(config_.scene.name);
    truth_ = scenes::SampleGroundTruth(scene_, config_.mission.truth_spacing_m);
    options_.folder = folder_ / "run";
    Begin();
  }
  ~MissionMetricsTest() override { fs::remove_all(folder_); }

  /// A run anew, of the configuration as it is.
  void Begin() {
    metrics_.reset();
    fs::remove_all(options_.folder);
    metrics_.emplace(config_, options_, scene_, robot_);
    metrics_->Attach(&simulator_);
  }

  /// One scan that brings returns from these truth points, each seen from before its face; its row of
  /// steps.csv.
  tests::CsvRow ScanOf(const std::vector<size_t>& seen) {
    mapping::ReturnCloud cloud;
    for (const size_t i : seen) cloud.Add(truth_.points[i], truth_.points[i] + truth_.normals[i]);
    return ScanThatBrings(cloud);
  }
  tests::CsvRow ScanThatBrings(const mapping::ReturnCloud& cloud, const planner::DecisionLog& log = {},
                               const planner::Decision& decision = planner::GoScan{}) {
    metrics_->BeginScan();
    metrics_->ObserveSweep(core::Pose::Identity());
    metrics_->TakeCloud(cloud, 0, poses_);
    metrics_->ScoreClouds(map_, poses_);
    metrics_->AdoptScore();
    metrics_->FinishScan(decision, log);
    return tests::ReadCsv(options_.folder / "steps.csv").back();
  }
  RunSummary Finish(RunStatus status, StopReason reason) {
    metrics_->Save(map_);
    return metrics_->Finish(status, reason);
  }

  fs::path folder_ = fs::temp_directory_path() / ("atlas_judge_" + std::to_string(::getpid()));
  ExperimentConfig config_;
  RunOptions options_;
  scenes::SceneSpec scene_;
  robots::RobotSpec robot_ = robots::LoadRobot("quadruped");
  scenes::GroundTruth truth_;
  tests::FakeSimulator simulator_;
  SilentMap map_;
  mapping::FixedPoses poses_{{core::Pose::Identity()}};
  std::optional<MissionMetrics> metrics_;
};

double Number(const tests::CsvRow& row, const std::string& column) {
  return std::stod(row.at(column));
}

TEST_F(MissionMetricsTest, AllThatIsAttainableIsOneHoweverMuchElseIsCovered) {
  std::vector<size_t> all(truth_.points.size());
  std::iota(all.begin(), all.end(), size_t{0});
  const tests::CsvRow row = ScanOf(all);
  EXPECT_EQ(Number(row, "coverage"), 1.0);
  EXPECT_EQ(Number(row, "coverage_of_attainable"), 1.0);
  const RunSummary summary = Finish(RunStatus::kBudget, StopReason::kScanBudget);
  EXPECT_LT(summary.Number("coverage_attainable").value(), 0.95) << "the top is out of reach";
  EXPECT_GT(summary.Number("coverage_attainable").value(), 0.5);
}

TEST_F(MissionMetricsTest, WhereNobodyAsksForWhatIsAttainableItsColumnsAreEmptyAndNothingElse) {
  config_.mission.attainable = false;
  Begin();
  const tests::CsvRow row = ScanOf({truth_.points.size() / 2});
  EXPECT_GT(Number(row, "coverage_outer"), 0.0);
  EXPECT_EQ(row.at("coverage_of_attainable"), "");
  const RunSummary summary = Finish(RunStatus::kBudget, StopReason::kScanBudget);
  EXPECT_GT(summary.Number("coverage").value(), 0.0);
  for (const char* key : {"coverage_attainable", "coverage_of_attainable", "t50_s"})
    EXPECT_FALSE(summary.Number(key)) << key;
  const tests::CsvRow part = tests::ReadCsv(options_.folder / "coverage_by_part.csv").at(0);
  EXPECT_EQ(part.at("attainable") + part.at("coverage_of_attainable"), "");
  EXPECT_EQ(core::ReadFile(options_.folder / "ground_truth.ply").find("attainable"), std::string::npos);
}

TEST_F(MissionMetricsTest, WhatLiesOutOfReachCountsForCoverageAndNotForItsShareOfTheAttainable) {
  std::vector<size_t> top;  // but for what returns from the sides cover
  for (size_t i = 0; i < truth_.points.size(); ++i) {
    const Vec3f& p = truth_.points[i];
    if (p.z() > 1.39f && std::max(std::abs(p.x()), std::abs(p.y())) < 0.3f) top.push_back(i);
  }
  ASSERT_GT(top.size(), 50u);
  const tests::CsvRow row = ScanOf(top);
  EXPECT_GT(Number(row, "coverage"), 0.03);
  EXPECT_EQ(Number(row, "coverage_of_attainable"), 0.0);
}

TEST_F(MissionMetricsTest, APointCoversWhatLiesWithinHalfTheDiagonalOfAFiveCentimetreVoxel) {
  EXPECT_NEAR(MissionParams{}.coverage_radius_m, 0.5 * std::sqrt(3.0) * 0.05, 0.0005);
  EXPECT_EQ(kObjectCoverageRadiusM, MissionParams{}.coverage_radius_m);
  EXPECT_EQ(kAreaCoverageRadiusM, 2.0 * kObjectCoverageRadiusM);
  const size_t chosen = truth_.points.size() / 2;
  const Vec3f single = truth_.points[chosen];
  const auto near = std::count_if(truth_.points.begin(), truth_.points.end(),
                                  [&](const Vec3f& p) { return (p - single).norm() <= 0.043f; });
  const tests::CsvRow row = ScanOf({chosen});
  EXPECT_NEAR(Number(row, "coverage_raw"),
              static_cast<double>(near) / static_cast<double>(truth_.points.size()), 1e-6);
}

TEST_F(MissionMetricsTest, EveryCountOfSafetyReachesItsColumnAndTheSummary) {
  simulator_.counts = {.falls = 1,
                       .collisions = 2,
                       .shank_brushes = 3,
                       .footholds = 400,
                       .footholds_off_solid = 5,
                       .worst_foot_drop_m = 0.0625};
  const tests::CsvRow row = ScanOf({});
  EXPECT_EQ(row.at("falls"), "1");
  EXPECT_EQ(row.at("collisions"), "2");
  EXPECT_EQ(row.at("shank_brushes"), "3");
  EXPECT_EQ(row.at("footholds"), "400");
  EXPECT_EQ(row.at("footholds_off_solid"), "5");
  EXPECT_EQ(Number(row, "worst_foot_drop_m"), 0.0625);
  simulator_.counts.falls = 2;
  simulator_.counts.collisions = 7;  // after the last scan
  const RunSummary summary = Finish(RunStatus::kRobotFell, StopReason::kFell);
  EXPECT_EQ(summary.Number("falls"), 2.0);
  EXPECT_EQ(summary.Number("collisions"), 7.0);
}

TEST_F(MissionMetricsTest, WhatNoPhysicsMeasuresStaysEmpty) {
  simulator_.counts.measured = false;
  const tests::CsvRow row = ScanOf({});
  for (const char* column :
       {"falls", "collisions", "shank_brushes", "footholds", "footholds_off_solid", "worst_foot_drop_m"}) {
    EXPECT_EQ(row.at(column), "") << column;
  }
}

TEST_F(MissionMetricsTest, TheDecisionOfAScanStandsInItsRow) {
  planner::DecisionLog decision;
  decision.candidates.resize(3);
  decision.views_predicted = 3;
  decision.candidates[1].gain = 11.5;
  decision.candidates[1].utility = 2.25;
  decision.best = 1;
  decision.nodes_obtained = 17;
  decision.rays_traced = 1234;
  decision.utility_ratio = 0.375;
  decision.path_length_m = 4.5;
  simulator_.time = 33.5;
  metrics_->BeginScan();
  metrics_->ObserveSweep(core::PoseFromXyzYaw({1.0, 2.0, 3.0}, 0.5));
  metrics_->ObserveMap(777, 1.0, 88);
  metrics_->ScoreClouds(map_, poses_);
  metrics_->AdoptScore();
  metrics_->FinishScan(planner::GoScan{}, decision);
  metrics_->ObserveWalk({.distance_m = 6.5}, 0.0);
  const tests::CsvRow row = tests::ReadCsv(options_.folder / "steps.csv").at(0);
  const std::map<std::string, double> expected = {{"scan", 1},
                                                  {"sim_time_s", 33.5},
                                                  {"distance_m", 0},
                                                  {"x_m", 1},
                                                  {"y_m", 2},
                                                  {"z_m", 3},
                                                  {"yaw_rad", 0.5},
                                                  {"cloud_points", 777},
                                                  {"new_surface_voxels", 88},
                                                  {"candidates", 3},
                                                  {"nodes", 17},
                                                  {"rays", 1234},
                                                  {"gain", 11.5},
                                                  {"utility", 2.25},
                                                  {"utility_ratio", 0.375},
                                                  {"path_length_m", 4.5}};
  for (const auto& [column, value] : expected) EXPECT_EQ(Number(row, column), value) << column;
  EXPECT_EQ(row.at("outcome"), "view");
  EXPECT_EQ(Number(ScanOf({}), "distance_m"), 6.5);
}

TEST_F(MissionMetricsTest, WhatThePlannerDoesNotComputeIsEmptyAndNoZero) {
  planner::DecisionLog decision;
  decision.candidates.resize(1);
  decision.best = 0;
  const tests::CsvRow row = ScanThatBrings({}, decision);
  for (const char* column : {"candidates", "gain", "utility", "utility_ratio"}) {
    EXPECT_EQ(row.at(column), "") << column;
  }
  EXPECT_FALSE(Finish(RunStatus::kBudget, StopReason::kScanBudget).Number("blocked_ways").has_value());
  const tests::CsvRow candidate = tests::ReadCsv(options_.folder / "candidates.csv").at(0);
  for (const auto& [column, cell] : candidate) {
    const bool is_place = column == "scan" || column == "candidate" || column == "node" || column == "x_m" ||
                          column == "y_m" || column == "yaw_rad" || column == "ground_m" ||
                          column == "path_length_m" || column == "reason";
    EXPECT_EQ(cell.empty(), !is_place) << column << ": " << cell;
  }
}

TEST_F(MissionMetricsTest, TheCloudsErrorIsMeanAndTailAndLeavesOutWhatStandsAround) {
  mapping::ReturnCloud cloud;
  for (size_t i = 0; i < truth_.points.size(); ++i) {
    const float off_m = i % 8 == 0 ? 0.02f : 0.0f;  // an eighth lies two centimetres before the surface
    cloud.Add(truth_.points[i] + off_m * truth_.normals[i], truth_.points[i] + truth_.normals[i]);
  }
  for (float x = -0.58f; x < 0.59f; x += 0.01f) {  // a kerb within the object's box
    cloud.Add(Vec3f(x, -0.58f, 0.06f), Vec3f(x, -2.0f, 0.5f));
  }
  const tests::CsvRow row = ScanThatBrings(cloud);
  EXPECT_NEAR(Number(row, "cloud_error_m_mean"), 0.0025, 0.0005);
  EXPECT_NEAR(Number(row, "cloud_error_m_p95"), 0.02, 0.001);
  const RunSummary summary = Finish(RunStatus::kBudget, StopReason::kScanBudget);
  EXPECT_NEAR(summary.Number("cloud_error_m_mean").value(), 0.0025, 0.0005);
  EXPECT_NEAR(summary.Number("cloud_error_m_p95").value(), 0.02, 0.001);
}

TEST_F(MissionMetricsTest, ThePartsColumnsAreThoseOfTheirNames) {
  // One part: its shares are the scene's. Some of it is seen from behind, and nothing of the top.
  mapping::ReturnCloud cloud;
  for (size_t i = 0; i < truth_.points.size(); ++i) {
    if (truth_.points[i].x() < 0.1f || truth_.points[i].z() > 1.3f) continue;
    const float side = truth_.points[i].y() > 0.1f ? -0.1f : 1.0f;
    cloud.Add(truth_.points[i], truth_.points[i] + side * truth_.normals[i]);
  }
  ScanThatBrings(cloud);
  const RunSummary summary = Finish(RunStatus::kBudget, StopReason::kScanBudget);
  const std::vector<double> shares = {
      summary.Number("coverage_attainable").value(), summary.Number("coverage").value(),
      summary.Number("coverage_outer").value(), summary.Number("coverage_of_attainable").value()};
  for (size_t a = 0; a < shares.size(); ++a) {
    for (size_t b = 0; b < a; ++b) EXPECT_GT(std::abs(shares[a] - shares[b]), 0.005) << a << " " << b;
  }
  const std::vector<tests::CsvRow> parts = tests::ReadCsv(options_.folder / "coverage_by_part.csv");
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].at("part"), "block");
  EXPECT_NEAR(Number(parts[0], "attainable"), shares[0], 1e-4);
  EXPECT_NEAR(Number(parts[0], "coverage"), shares[1], 1e-4);
  EXPECT_NEAR(Number(parts[0], "coverage_outer"), shares[2], 1e-4);
  EXPECT_NEAR(Number(parts[0], "coverage_of_attainable"), shares[3], 1e-4);
}

TEST_F(MissionMetricsTest, WhatCameAfterTheLastScoreCountsNowhere) {
  mapping::ReturnCloud all;
  for (size_t i = 0; i < truth_.points.size(); ++i)
    all.Add(truth_.points[i] + 0.01f * truth_.normals[i], truth_.points[i] + truth_.normals[i]);
  const tests::CsvRow row = ScanOf({truth_.points.size() / 2});
  metrics_->TakeCloud(all, 0, poses_);
  const RunSummary summary = Finish(RunStatus::kRobotFell, StopReason::kFell);
  EXPECT_LT(summary.Number("coverage").value(), 0.1);
  EXPECT_LT(summary.Number("cloud_error_m_mean").value(), 0.001);
  const tests::CsvRow part = tests::ReadCsv(options_.folder / "coverage_by_part.csv").at(0);
  EXPECT_NEAR(Number(part, "coverage"), summary.Number("coverage").value(), 1e-4);
  EXPECT_NEAR(Number(part, "coverage_outer"), Number(row, "coverage_outer"), 1e-4);
}

TEST_F(MissionMetricsTest, AMissionWithoutAScanHasCoveredNothing) {
  metrics_->BeginScan();  // and the robot falls while it sweeps
  const RunSummary summary = Finish(RunStatus::kInterrupted, StopReason::kSignal);
  const tests::CsvRow part = tests::ReadCsv(options_.folder / "coverage_by_part.csv").at(0);
  EXPECT_GT(Number(part, "attainable"), 0.5);
  EXPECT_EQ(Number(part, "coverage"), 0.0);
  EXPECT_EQ(summary.Number("scans"), 0.0);
  EXPECT_FALSE(summary.Number("blocked_ways").has_value()) << "no plan looked for any";
}

TEST_F(MissionMetricsTest, ScansAreTheRowsOfStepsCsv) {
  for (int scan = 1; scan <= 2; ++scan) {
    ScanOf({});
    EXPECT_EQ(metrics_->scans_begun(), scan);
  }
  metrics_->BeginScan();
  EXPECT_EQ(metrics_->scans_begun(), 3) << "what the budget counts";
  const RunSummary summary = Finish(RunStatus::kInterrupted, StopReason::kSignal);
  EXPECT_EQ(tests::ReadCsv(options_.folder / "steps.csv").size(), 2u);
  EXPECT_EQ(summary.Number("scans"), 2.0);
}

TEST_F(MissionMetricsTest, OfWaysTooNarrowThoseAreNamedThatAreWorthWalking) {
  planner::DecisionLog decision;
  decision.blocked.emplace(3);
  (*decision.blocked)[0].p_map = {1.25, -2.0};
  (*decision.blocked)[0].worth_share = 0.9;
  (*decision.blocked)[0].promises = true;
  (*decision.blocked)[1].p_map = {3.25, 4.0};
  (*decision.blocked)[1].worth_share = 0.001;
  (*decision.blocked)[2].p_map = {-5.25, 4.0};  // never judged
  const auto end = [&](planner::Done::Reason reason) {
    ScanThatBrings({}, decision, planner::Done{reason});
    return Finish(RunStatus::kBudget, StopReason::kBlockedNarrow);
  };
  const RunSummary other = end(planner::Done::Reason::kGainExhausted);
  EXPECT_EQ(other.Number("blocked_ways"), 3.0);
  EXPECT_EQ(other.blocked_at, "") << "that is not why it ended";
  const RunSummary blocked = end(planner::Done::Reason::kBlockedNarrow);
  EXPECT_EQ(blocked.Number("blocked_ways"), 3.0);
  EXPECT_NE(blocked.blocked_at.find("1.2"), std::string::npos) << blocked.blocked_at;
  EXPECT_EQ(blocked.blocked_at.find(';'), std::string::npos) << blocked.blocked_at;
}

TEST_F(MissionMetricsTest, CoverageIsFlatOnlyOnceScansAddLittle) {
  const size_t fifth = truth_.points.size() / 5;
  std::vector<size_t> seen(fifth);
  for (size_t scan = 0; scan < 5; ++scan) {
    std::iota(seen.begin(), seen.end(), scan * fifth);
    EXPECT_EQ(ScanOf(seen).at("flat_by_truth"), "0") << scan;
  }
  for (int scan = 1; scan < config_.mission.flat_scans; ++scan) {
    EXPECT_EQ(ScanOf({}).at("flat_by_truth"), "0") << "scans before this one added much";
  }
  EXPECT_EQ(ScanOf({}).at("flat_by_truth"), "1");
}

TEST_F(MissionMetricsTest, TrajectoriesKeepTruthAndOdometryApart) {
  simulator_.T_map_base_true = core::PoseFromXyzYaw({1.0, 0.0, 0.0}, 0.0);
  simulator_.T_odom_base_now = core::PoseFromXyzYaw({0.0, 2.0, 0.0}, 0.0);
  simulator_.observers.at(0)(sim::Snapshot{});
  ScanOf({});
  EXPECT_NE(core::ReadFile(options_.folder / "trajectory_truth.tum").find(" 1.000000 0.000000"),
            std::string::npos);
  EXPECT_NE(core::ReadFile(options_.folder / "trajectory_odom.tum").find(" 0.000000 2.000000"),
            std::string::npos);
}

}  // namespace
}  // namespace atlas::experiments
