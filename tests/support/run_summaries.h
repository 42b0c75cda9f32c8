// Runs as tables take them, made up.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "experiments/report/text_table.h"
#include "experiments/results/run_summary.h"

namespace atlas::testing {

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
  s.coverage = coverage;
  s.coverage_attainable = 0.9;
  s.coverage_of_attainable = coverage / 0.9;
  s.travel_distance_m = 40.0;
  s.scans = 11;
  s.sim_time_s = 746.4;
  s.nbv_time_s_mean = 0.5;
  s.real_time_factor = 9.0;
  s.falls = 0;
  s.collisions = 0;
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

}  // namespace atlas::testing
