// Every metric of the catalogue fed with one made-up run; its columns are those that it declares.
#include <gtest/gtest.h>

#include <set>

#include "experiments/judge/metric.h"
#include "experiments/report/mapper_pairs.h"
#include "experiments/report/table_columns.h"
#include "experiments/results/run_recorder.h"

namespace atlas::experiments {
namespace {

JudgedScan Scan(int number, double share) {
  JudgedScan scan;
  scan.scan = number;
  scan.sim_time_s = 30.0 * number;
  scan.score.coverage = 0.9 * share;
  scan.score.of_attainable = share;
  scan.score.error = {100, 0.004, 0.02};
  scan.score.explored_m3 = 12.5;
  scan.safety.measured = true;
  scan.safety.collisions = number;
  scan.times.nbv_time_s = 0.2 * number;
  scan.times.integration_ms = 20.0 * number - 10.0;
  scan.log.candidates.resize(4);
  scan.log.views_predicted = 4;
  return scan;
}

struct Fed {
  std::vector<core::Row> steps, times;
  core::Row summary;
};

Fed FeedAll(const std::vector<JudgedScan>& scans) {
  Fed fed;
  std::vector<std::unique_ptr<Metric>> metrics;
  for (const MetricEntry& entry : MetricCatalog()) metrics.push_back(entry.build({0.015, 1}));
  for (const JudgedScan& scan : scans) {
    fed.steps.emplace_back();
    fed.times.emplace_back();
    for (const auto& metric : metrics) metric->OnScan(scan, &fed.steps.back(), &fed.times.back());
  }
  const JudgedRun run{.scans = static_cast<int>(scans.size()),
                      .sim_time_s = 100.0,
                      .distance_m = 9.5,
                      .wall_time_s = 8.0,
                      .attainable = 0.9,
                      .attainable_m3 = 50.0,
                      .safety = scans.back().safety,
                      .score = scans.back().score,
                      .trajectory = TrajectoryErrors{3.0, 2.0, 1.0, 7},
                      .submaps = 5,
                      .odometry = mapping::OdometryHealth{.revolutions = 10, .lost = 1, .degenerate = 2},
                      .rooms = RoomScores{},
                      .planned_m = 12.0};
  for (const auto& metric : metrics) metric->Summarise(run, &fed.summary);
  return fed;
}

std::set<std::string> Names(const std::vector<core::Column>& columns) {
  std::set<std::string> names;
  for (const core::Column& column : columns) {
    EXPECT_TRUE(names.insert(column.name).second) << column.name << " is declared twice";
    EXPECT_FALSE(column.meaning.empty()) << column.name;
  }
  return names;
}

std::set<std::string> Names(const core::Row& row) {
  std::set<std::string> names;
  for (const auto& [name, cell] : row.cells()) names.insert(name);
  return names;
}

TEST(Metrics, WriteTheColumnsThatTheyDeclareAndNoOthers) {
  const Fed fed = FeedAll({Scan(1, 0.4), Scan(2, 0.92)});
  EXPECT_EQ(Names(fed.steps.front()), Names(StepColumns()));
  EXPECT_EQ(Names(fed.times.front()), Names(TimesColumns()));
  EXPECT_EQ(Names(fed.summary), Names(SummaryColumns()));
}

TEST(Metrics, SummariesFollowTheScans) {
  const core::Row s = FeedAll({Scan(1, 0.4), Scan(2, 0.92)}).summary;
  EXPECT_EQ(s.Number("scans"), 2.0);
  EXPECT_EQ(s.Number("ate_odometry_m"), 3.0);
  EXPECT_EQ(s.Number("ate_believed_m"), 2.0);
  EXPECT_EQ(s.Number("ate_m"), 1.0);
  EXPECT_EQ(s.Number("keyframes"), 7.0);
  EXPECT_EQ(s.Number("submaps"), 5.0);
  EXPECT_NEAR(*s.Number("coverage"), 0.828, 1e-9);
  EXPECT_NEAR(*s.Number("coverage_of_attainable"), 0.92, 1e-9);
  EXPECT_NEAR(*s.Number("coverage_attainable"), 0.9, 1e-9);
  EXPECT_NEAR(*s.Number("real_time_factor"), 12.5, 1e-9);
  EXPECT_NEAR(*s.Number("nbv_time_s_mean"), 0.3, 1e-9);
  EXPECT_NEAR(*s.Number("integration_ms_p95"), 29.0, 1e-9);
  EXPECT_EQ(s.Number("collisions"), 2.0);
  EXPECT_EQ(s.Number("t50_s"), 60.0);
  EXPECT_EQ(s.Number("t90_s"), 60.0);
  EXPECT_FALSE(s.Number("t95_s").has_value());
  EXPECT_NEAR(*s.Number("explored_of_attainable"), 0.25, 1e-9);
  EXPECT_EQ(s.Number("flat_by_truth"), 0.0);
  EXPECT_EQ(FeedAll({Scan(1, 0.4), Scan(2, 0.41)}).summary.Number("flat_by_truth"), 1.0);
}

TEST(Metrics, WhatWasNotMeasuredIsNotWritten) {
  JudgedScan kinematic = Scan(1, 0.4);
  kinematic.safety.measured = false;
  kinematic.score.error = {};
  const Fed fed = FeedAll({kinematic});
  for (const char* key : {"falls", "collisions", "worst_foot_drop_m", "cloud_error_m_mean"}) {
    EXPECT_FALSE(fed.summary.Number(key).has_value()) << key;
    EXPECT_FALSE(fed.steps.front().Number(key).has_value()) << key;
  }
}

TEST(Metrics, DeclareEveryNumberThatTablesPairsAndPicturesShow) {
  const std::set<std::string> summary = Names(SummaryColumns()), steps = Names(StepColumns());
  int shown = 0;
  for (const Column& column : TableColumns()) {
    if (column.number.empty()) continue;
    EXPECT_TRUE(summary.contains(column.number)) << column.heading << " shows " << column.number;
    ++shown;
  }
  EXPECT_GT(shown, 10);
  for (const PairRatio& ratio : kPairRatios) EXPECT_TRUE(summary.contains(ratio.number)) << ratio.number;
  for (const PictureCurve& curve : kPictureCurves) EXPECT_TRUE(steps.contains(curve.column)) << curve.column;
  EXPECT_TRUE(summary.contains(kPictureCeiling.column));
}

/// What declares a number as a table's words mean it is what the table says.
TEST(Metrics, LendTablesTheirMeanings) {
  int lent = 0;
  for (const Column& column : TableColumns()) {
    for (const core::Column& declared : SummaryColumns()) {
      lent += column.number == declared.name && column.meaning == declared.meaning;
    }
  }
  EXPECT_GE(lent, 5);
}

}  // namespace
}  // namespace atlas::experiments
