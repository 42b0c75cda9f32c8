// The run folder as it grows: rows a scan, candidates, trajectories, summary and the coverage picture.
//
// The folder is valid at any time: after each scan every file is rewritten whole (core::WriteFileAtomically),
// and until Finish summary.json says `interrupted` (`failed` once an exception has passed). steps.csv holds
// nothing that depends on the machine's speed, so the same seed gives the same bytes; wall-clock times go to
// timings.csv.
#pragma once

#include <array>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry.h"
#include "core/table.h"
#include "experiments/results/run_summary.h"
#include "planner/decision.h"

namespace atlas::experiments {

/// What stands in steps.csv and timings.csv.
struct RunColumns {
  std::vector<core::Column> steps, times;
};

/// A curve of coverage.svg: a column of steps.csv over `scan`.
struct PictureCurve {
  const char* column;
  const char* label;
};
inline constexpr std::array<PictureCurve, 3> kPictureCurves = {
    {{"coverage", "coverage (Eq. 3.9)"},
     {"coverage_outer", "from the outer side"},
     {"coverage_of_attainable", "share of the attainable"}}};
/// The level line there: a number of summary.json.
inline constexpr PictureCurve kPictureCeiling = {"coverage_attainable", "attainable"};

class RunRecorder {
 public:
  /// @param identity who ran what (text fields and seed); its numbers may hold what is known beforehand.
  /// @throws InputError when the folder cannot be written.
  RunRecorder(const std::filesystem::path& folder, const RunSummary& identity, RunColumns columns);
  /// Where an exception passes before Finish, the run failed, and its summary says so.
  ~RunRecorder();
  RunRecorder(const RunRecorder&) = delete;
  RunRecorder& operator=(const RunRecorder&) = delete;

  const std::filesystem::path& folder() const { return folder_; }

  /// Numbers, and words that only a mission tells: set at any time.
  RunSummary* mutable_summary() { return &summary_; }

  /// True and odometric base poses, by ascending time; kept at 10 Hz or whatever is given.
  void AddPose(double time_s, const core::Pose& T_map_base_true, const core::Pose& T_odom_base);

  /// The decision after scan `scan`, every candidate a row of candidates.csv.
  void AddDecision(int scan, const planner::DecisionLog& log, const std::vector<std::string>& extra_gains);

  /// Appends a scan and rewrites the folder.
  void AddStep(const core::Row& step, const core::Row& times);

  /// Final state. Returns the summary as written.
  const RunSummary& Finish(RunStatus status, StopReason reason);

 private:
  void Write() const;

  std::filesystem::path folder_;
  RunSummary summary_;
  bool finished_ = false;
  int exceptions_ = std::uncaught_exceptions();  ///< under way when this was made
  RunColumns columns_;
  std::vector<core::Row> steps_;
  std::string steps_csv_, timings_csv_, candidates_csv_;
  std::string truth_tum_, odom_tum_;
};

/// The outcome's word in steps.csv.
std::string_view NameOf(const planner::Decision& decision);
std::string_view NameOf(planner::LossReason reason);

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
