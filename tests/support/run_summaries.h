// Runs as tables take them, made up.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "experiments/report/text_table.h"
#include "experiments/results/run_summary.h"

namespace atlas::tests {

/// A run of `experiment` that completed: greedy, occlusion_aware, OctoMap, trot.
inline experiments::RunSummary RunOf(const std::string& experiment, uint64_t seed, double coverage) {
  experiments::RunSummary s;
  s.experiment = experiment;
  s.gain = "occlusion_aware";
  s.planner = "greedy";
  s.mapper = "octomap";
  s.locomotion = "trot";
  s.seed = seed;
  s.status = experiments::RunStatus::kCompleted;
  s.stop_reason = experiments::StopReason::kGainExhausted;
  s.numbers.Set("coverage", coverage);
  s.numbers.Set("coverage_attainable", 0.9);
  s.numbers.Set("coverage_of_attainable", coverage / 0.9);
  s.numbers.Set("travel_distance_m", 40.0);
  s.numbers.Set("scans", 11);
  s.numbers.Set("sim_time_s", 746.4);
  s.numbers.Set("nbv_time_s_mean", 0.5);
  s.numbers.Set("real_time_factor", 9.0);
  s.numbers.Set("falls", 0);
  s.numbers.Set("collisions", 0);
  return s;
}

/// The cell under `heading`; fails the test where there is no such column.
inline std::string Cell(const experiments::TextTable& table, size_t row, const std::string& heading) {
  for (size_t i = 0; i < table.heading.size(); ++i) {
    if (table.heading[i] == heading) return table.rows.at(row).at(i);
  }
  ADD_FAILURE() << "no column " << heading;
  return "";
}

}  // namespace atlas::tests
