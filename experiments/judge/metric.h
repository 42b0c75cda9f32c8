// What a run is measured by: one file a metric in judge/metrics, one line in its catalog.inc.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/table.h"
#include "experiments/judge/cloud_score.h"
#include "experiments/judge/place_errors.h"
#include "experiments/judge/room_scores.h"
#include "experiments/judge/scan_times.h"
#include "mapping/slam/localiser.h"
#include "planner/decision.h"
#include "sim/simulator.h"

namespace atlas::experiments {

/// All that is known of a scan when its plan is made.
struct JudgedScan {
  int scan = 0;                                    ///< from 1
  double sim_time_s = 0.0;                         ///< at the end of the sweep
  double distance_m = 0.0;                         ///< walked so far by the true base
  core::Pose T_map_base = core::Pose::Identity();  ///< estimate the sweep was taken under
  size_t cloud_points = 0;                         ///< filtered, since the scan before
  size_t new_surface_voxels = 0;                   ///< newly occupied
  CloudScore score;                                ///< of all clouds so far
  planner::Decision decision;                      ///< that followed
  planner::DecisionLog log;
  sim::SafetyCounts safety;  ///< so far
  ScanTimes times;
};

/// What is known of a run so far.
struct JudgedRun {
  int scans = 0;  ///< rows of steps.csv
  double sim_time_s = 0.0, distance_m = 0.0, wall_time_s = 0.0;
  std::optional<double> attainable;     ///< share of the truth that a perfect run covers from its outer side
  std::optional<double> attainable_m3;  ///< of scenes to explore
  sim::SafetyCounts safety;
  CloudScore score;
  std::optional<TrajectoryErrors> trajectory = {};
  size_t submaps = 1;
  std::optional<mapping::OdometryHealth> odometry = {};
  std::optional<RoomScores> rooms = {};  ///< of a scene that tells its rooms and a map that has submaps
  std::optional<double> planned_m = {};  ///< length of the way that mission.plan_after found
};

/// From what kind of run.
struct MetricSetup {
  double flat_coverage = 0.015;
  int flat_scans = 3;
};

/// Holds what it needs of earlier scans.
class Metric {
 public:
  virtual ~Metric() = default;
  /// Fills its columns of steps.csv; those of timings.csv, which depend on the machine, go to `times`.
  virtual void OnScan(const JudgedScan& scan, core::Row* step, core::Row* times) = 0;
  /// Fills its keys of summary.json, after every scan and at the end.
  virtual void Summarise(const JudgedRun& run, core::Row* summary) const = 0;
};

struct MetricEntry {
  std::string name;
  std::string doc;
  std::vector<core::Column> steps = {}, times = {}, summary = {};
  std::unique_ptr<Metric> (*build)(const MetricSetup& setup);
};
const std::vector<MetricEntry>& MetricCatalog();

/// The columns of all metrics, in the catalogue's order.
std::vector<core::Column> StepColumns();
std::vector<core::Column> TimesColumns();
std::vector<core::Column> SummaryColumns();

}  // namespace atlas::experiments
