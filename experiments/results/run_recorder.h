// The run folder as it grows: rows a scan, candidates, trajectories, summary and the coverage picture.
//
// The folder is valid at any time: after each scan every file is rewritten whole (core::WriteFileAtomically),
// and until Finish summary.json says `interrupted` (`failed` once an exception has passed). steps.csv holds
// nothing that depends on the machine's speed, so the same seed gives the same bytes; wall-clock times go to
// timings.csv.
#pragma once

#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "experiments/results/run_summary.h"
#include "planner/planners/nbv_planner.h"

namespace atlas::experiments {

/// One scan: the sweep taken, and the decision that followed it. Cumulative where said.
struct StepRow {
  int scan = 0;                                    ///< from 1
  double sim_time_s = 0.0;                         ///< at the end of the sweep
  double distance_m = 0.0;                         ///< walked so far by the true base
  core::Pose T_map_base = core::Pose::Identity();  ///< estimate the sweep was taken under
  double coverage_raw = 0.0;
  double coverage = 0.0;        ///< aligned, thesis Eq. 3.9
  double coverage_outer = 0.0;  ///< aligned, by returns from the outer side
  std::optional<double> coverage_of_attainable;
  bool flat_by_truth = false;  ///< the truth's coverage has stopped growing; decides nothing
  std::optional<double> cloud_error_m_mean, cloud_error_m_p95;  ///< of the cloud so far, aligned
  size_t cloud_points = 0;                                      ///< of this sweep's filtered cloud
  size_t new_surface_voxels = 0;                                ///< newly occupied
  std::string outcome;  ///< view | gain_exhausted | surface_flat | no_candidates | ...
  int candidates = 0;
  int nodes = 0;
  size_t rays = 0;
  double gain = 0.0;           ///< of the chosen view
  double utility = 0.0;        ///< of the chosen view, Eq. 3.1
  double utility_ratio = 0.0;  ///< over the greatest so far
  double path_length_m = 0.0;
  /// So far; nothing where no physics runs.
  std::optional<int> falls, collisions, shank_brushes, footholds, footholds_off_solid;
  std::optional<double> worst_foot_drop_m;
  std::optional<double> explored_m3;  ///< known attainable volume, of scenes to explore
};

/// Wall-clock times of one scan.
struct TimingRow {
  int scan = 0;
  double nbv_time_s = 0.0;      ///< candidates, gains, costs, path
  double integration_ms = 0.0;  ///< mapper, the whole sweep
  double terrain_ms = 0.0;
  double metrics_ms = 0.0;
  double sweep_wall_s = 0.0;  ///< simulating the sweep
  double walk_wall_s = 0.0;   ///< simulating the walk that led here
  double wall_time_s = 0.0;   ///< since the run began
  size_t map_bytes = 0;
};

class RunRecorder {
 public:
  /// @param identity who ran what (text fields and seed); its numbers may hold what is known beforehand.
  /// @throws InputError when the folder cannot be written.
  RunRecorder(const std::filesystem::path& folder, const RunSummary& identity);
  /// Where an exception passes before Finish, the run failed, and its summary says so.
  ~RunRecorder();
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

  /// Numbers that the rows do not hold (coverage_attainable, cloud_error_m_*, submaps, ate_m ...): set at any
  /// time.
  RunSummary* mutable_summary() { return &summary_; }

  /// True and odometric base poses, by ascending time; kept at 10 Hz or whatever is given.
  void AddPose(double time_s, const core::Pose& T_map_base_true, const core::Pose& T_odom_base);

  /// The decision after scan `scan`, every candidate a row of candidates.csv.
  void AddDecision(int scan, const planner::NbvDecision& decision,
                   const std::vector<std::string>& extra_gains);

  /// Appends a scan and rewrites the folder.
  void AddStep(const StepRow& step, const TimingRow& timing);

  /// Final state. `sim_time_s`, `distance_m` and `wall_time_s` of the whole run, walks after the last scan
  /// included. Returns the summary as written.
  const RunSummary& Finish(RunStatus status, StopReason reason, double sim_time_s, double distance_m,
                           double wall_time_s);

  const std::vector<StepRow>& steps() const { return steps_; }

 private:
  void Summarise();
  void Write() const;

  std::filesystem::path folder_;
  RunSummary summary_;
  bool finished_ = false;
  int exceptions_ = std::uncaught_exceptions();  ///< under way when this was made
  std::vector<StepRow> steps_;
  std::vector<TimingRow> timings_;
  std::string candidates_csv_;
  std::string truth_tum_, odom_tum_;
};

/// The outcome's word in steps.csv.
std::string_view NameOf(planner::NbvOutcome outcome);
std::string_view NameOf(planner::LossReason reason);

/// Rows as they stand in steps.csv, header first.
std::string StepsCsv(const std::vector<StepRow>& steps);
std::string TimingsCsv(const std::vector<TimingRow>& timings);

/// Coverage curve of one run as read back from its steps.csv, for plots.
struct CoverageCurve {
  std::vector<double> scan, sim_time_s, distance_m, coverage_raw, coverage;
  std::vector<double> coverage_of_attainable;  ///< empty where the run has none
};
/// @throws InputError for a missing file, a missing column or a cell that is not a number.
CoverageCurve LoadCoverageCurve(const std::filesystem::path& run_folder);
/// Where the scans of steps.csv were taken, as the robot believed; errors as above.
std::vector<core::Vec2> LoadScanPlaces(const std::filesystem::path& run_folder);

}  // namespace atlas::experiments
