#include "experiments/results/run_recorder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "experiments/judge/metric.h"

namespace atlas::experiments {
namespace {
namespace fs = std::filesystem;

class RunRecorderTest : public ::testing::Test {
 protected:
  RunRecorderTest() {
    folder_ =
        fs::temp_directory_path() /
        ("atlas_recorder_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(folder_);
    identity_.experiment = "helicopter";
    identity_.scene = "helicopter";
    identity_.gain = "occlusion_aware";
    identity_.planner = "greedy";
    identity_.seed = 7;
  }
  ~RunRecorderTest() override { fs::remove_all(folder_); }

  static core::Row Step(int scan, double share) {
    core::Row step;
    step.Set("scan", scan);
    step.Set("sim_time_s", 30.0 * scan);
    step.Set("distance_m", 4.5 * (scan - 1));
    step.Set("coverage", 0.9 * share);
    step.Set("coverage_raw", 0.85 * share);
    step.Set("coverage_of_attainable", share);
    step.Set("outcome", "view");
    return step;
  }
  static RunColumns Columns() { return {StepColumns(), TimesColumns()}; }

  fs::path folder_;
  RunSummary identity_;
};

TEST_F(RunRecorderTest, FolderIsValidAndInterruptedFromTheStart) {
  const RunRecorder recorder(folder_, identity_, Columns());
  const RunSummary summary = LoadRunSummary(folder_);
  EXPECT_EQ(summary.status, RunStatus::kInterrupted);
  EXPECT_EQ(summary.stop_reason, StopReason::kSignal);
  EXPECT_EQ(summary.seed, 7u);
  EXPECT_TRUE(LoadCoverageCurve(folder_).scan.empty());
  for (const char* name : {"steps.csv", "timings.csv", "candidates.csv", "trajectory_truth.tum",
                           "trajectory_odom.tum", "coverage.svg"}) {
    EXPECT_TRUE(fs::exists(folder_ / name)) << name;
  }
}

TEST_F(RunRecorderTest, NumbersAreKeptUntilTheFinalStatus) {
  RunRecorder recorder(folder_, identity_, Columns());
  recorder.mutable_summary()->numbers.Set("coverage_attainable", 0.9);
  recorder.AddStep(Step(1, 0.4), {});
  EXPECT_EQ(LoadRunSummary(folder_).status, RunStatus::kInterrupted);
  recorder.mutable_summary()->numbers.Set("scans", 1);
  recorder.mutable_summary()->numbers.Set("flat_by_truth", true);
  recorder.mutable_summary()->numbers.Set("t95_s", std::optional<double>());
  recorder.Finish(RunStatus::kCompleted, StopReason::kGainExhausted);
  const RunSummary s = LoadRunSummary(folder_);
  EXPECT_EQ(s.status, RunStatus::kCompleted);
  EXPECT_EQ(s.stop_reason, StopReason::kGainExhausted);
  EXPECT_EQ(s.Number("coverage_attainable"), 0.9);
  EXPECT_EQ(s.Number("scans"), 1.0);
  EXPECT_EQ(s.Number("flat_by_truth"), 1.0);
  EXPECT_FALSE(s.Number("t95_s").has_value());
}

TEST_F(RunRecorderTest, ARunThatAnExceptionEndedSaysSo) {
  try {
    RunRecorder recorder(folder_, identity_, Columns());
    recorder.AddStep(Step(1, 0.4), {});
    throw std::runtime_error("video");
  } catch (const std::runtime_error&) {
  }
  const RunSummary summary = LoadRunSummary(folder_);
  EXPECT_EQ(summary.status, RunStatus::kFailed);
  EXPECT_EQ(summary.stop_reason, StopReason::kError);
}

TEST_F(RunRecorderTest, TheFinalStatusIsWrittenAfterEveryOtherFile) {
  {
    RunRecorder recorder(folder_, identity_, Columns());
    recorder.AddStep(Step(1, 0.4), {});
    for (const char* name : {"steps.csv", "coverage.svg"}) {
      fs::remove(folder_ / name);
      fs::create_directories(folder_ / name / "in the way");
      EXPECT_THROW(recorder.Finish(RunStatus::kCompleted, StopReason::kGainExhausted), core::InputError);
      EXPECT_EQ(LoadRunSummary(folder_).status, RunStatus::kInterrupted) << name;
      fs::remove_all(folder_ / name);
    }
    recorder.Finish(RunStatus::kCompleted, StopReason::kGainExhausted);
  }
  EXPECT_EQ(LoadRunSummary(folder_).status, RunStatus::kCompleted);
}

TEST_F(RunRecorderTest, ControlCharactersInASummaryAreRefused) {
  identity_.experiment = "heli\x1b[2J\ncopter";
  try {
    SummaryFromJson(ToJson(identity_), "summary.json");
    FAIL();
  } catch (const core::InputError& error) {
    EXPECT_STREQ(error.what(),
                 "summary.json: experiment: holds a control character: 'heli\\x1b[2J\\ncopter'");
  }
}

TEST_F(RunRecorderTest, WordsComeFirstThenNumbersInTheirOrderCountsWhole) {
  RunSummary s = identity_;
  s.numbers.Set("scans", 3);
  s.numbers.Set("coverage", 0.123456789);
  const auto json = nlohmann::ordered_json::parse(ToJson(s));
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{"experiment", "scene", "planner", "gain", "seed", "status",
                                            "stop_reason", "scans", "coverage"}));
  EXPECT_TRUE(json["scans"].is_number_integer());
  EXPECT_EQ(json["coverage"].get<double>(), 0.123457);
}

TEST_F(RunRecorderTest, AWordAmongTheNumbersIsNotDroppedInSilence) {
  RunSummary s = identity_;
  s.numbers.Set("verdict", "good");
  EXPECT_THROW(ToJson(s), std::logic_error);
}

TEST_F(RunRecorderTest, CurveReadsBackWhatWasWritten) {
  RunRecorder recorder(folder_, identity_, Columns());
  recorder.AddStep(Step(1, 0.4), {});
  recorder.AddStep(Step(2, 0.8), {});
  const CoverageCurve curve = LoadCoverageCurve(folder_);
  EXPECT_EQ(curve.scan, (std::vector<double>{1, 2}));
  EXPECT_EQ(curve.coverage, (std::vector<double>{0.36, 0.72}));
  EXPECT_EQ(curve.coverage_of_attainable, (std::vector<double>{0.4, 0.8}));
}

TEST_F(RunRecorderTest, EveryCandidateIsARowWithItsReason) {
  RunRecorder recorder(folder_, identity_, Columns());
  planner::DecisionLog decision;
  decision.candidates.resize(3);
  decision.candidates[1].reason = planner::LossReason::kChosen;
  decision.candidates[2].extra_gains = {1.5};
  decision.best = 1;
  recorder.AddDecision(1, decision, {"unknown_volume"});
  recorder.AddStep(Step(1, 0.1), {});
  const std::string csv = core::ReadFile(folder_ / "candidates.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_NE(csv.find(",reason,gain_unknown_volume\n"), std::string::npos);
  EXPECT_NE(csv.find(",chosen,\n"), std::string::npos);
  EXPECT_NE(csv.find(",lower_utility,1.5\n"), std::string::npos);
}

TEST_F(RunRecorderTest, WhatAPlannerComputedOfACandidateStandsInItsColumn) {
  RunRecorder recorder(folder_, identity_, Columns());
  planner::DecisionLog decision;
  planner::Candidate& c = decision.candidates.emplace_back();
  c.gain = 1.0;
  c.gain_void = 2.0;
  c.gain_ground = 3.0;
  c.gain_object = 4.0;
  decision.candidates.push_back(c);
  planner::Candidate& charged = decision.candidates.back();
  charged.surface_m2 = 5.0;
  charged.worth = 6.0;
  charged.visited_cost = 0.1;
  charged.too_close_cost = 0.2;
  charged.position_cost = 0.3;
  charged.traversal_cost = 0.4;
  charged.utility = 7.0;
  recorder.AddDecision(1, decision, {});
  recorder.AddStep(Step(1, 0.1), {});
  const std::string csv = core::ReadFile(folder_ / "candidates.csv");
  EXPECT_NE(csv.find("gain,gain_void,gain_ground,gain_object,surface_m2,worth,visited_cost,too_close_cost,"
                     "position_cost,traversal_cost,utility,reason\n"),
            std::string::npos);
  EXPECT_NE(csv.find(",1,2,3,4,,,,,,,,lower_utility\n"), std::string::npos) << csv;
  EXPECT_NE(csv.find(",1,2,3,4,5,6,0.1000,0.2000,0.3000,0.4000,7,lower_utility\n"), std::string::npos) << csv;
}

TEST_F(RunRecorderTest, TrajectoriesAreTumLines) {
  RunRecorder recorder(folder_, identity_, Columns());
  recorder.AddPose(1.5, core::PoseFromXyzYaw({1, 2, 3}, core::kPi / 2), core::Pose::Identity());
  recorder.AddStep(Step(1, 0.1), {});
  EXPECT_EQ(core::ReadFile(folder_ / "trajectory_truth.tum"),
            "1.5000 1.000000 2.000000 3.000000 0.0000000 0.0000000 0.7071068 0.7071068\n");
}

TEST_F(RunRecorderTest, DamagedSummariesAreNamedInOneLine) {
  fs::create_directories(folder_);
  const auto message = [&](const std::string& text) {
    core::WriteFileAtomically(folder_ / "summary.json", text);
    try {
      LoadRunSummary(folder_);
    } catch (const core::InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(message("{\"experiment\": \"car\", \"sta").find("summary.json: not a JSON object"),
            std::string::npos);
  EXPECT_NE(message("{\"status\": \"completed\"}").find("experiment: missing"), std::string::npos);
  EXPECT_NE(message("{\"experiment\": \"car\", \"status\": \"great\"}").find("status: unknown value 'great'"),
            std::string::npos);
  EXPECT_NE(message("{\"experiment\": \"car\", \"status\": \"completed\", \"stop_reason\": \"bored\"}")
                .find("stop_reason: unknown value 'bored'"),
            std::string::npos);
  EXPECT_NE(
      message("{\"experiment\": \"car\", \"status\": \"completed\"}").find("stop_reason: unknown value ''"),
      std::string::npos);
  EXPECT_NE(message("{\"experiment\": \"car\", \"status\": \"budget\", \"coverage\": \"x\"}")
                .find("coverage: expected"),
            std::string::npos);
  EXPECT_THROW(LoadRunSummary(folder_ / "absent"), core::InputError);
}

TEST_F(RunRecorderTest, AnUnwritableFolderIsBadInput) {
  fs::create_directories(folder_);
  core::WriteFileAtomically(folder_ / "file", "x");
  EXPECT_THROW(RunRecorder(folder_ / "file" / "run", identity_, Columns()), core::InputError);
}

}  // namespace
}  // namespace atlas::experiments
