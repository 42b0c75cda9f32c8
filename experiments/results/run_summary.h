// What one run comes to: the flat keys of summary.json, written and read through one list so that they cannot
// disagree.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace atlas::experiments {

enum class RunStatus { kCompleted, kBudget, kRobotFell, kStuck, kInterrupted, kFailed };
/// `completed` goes with the first four only: what ends a mission by its own criterion.
enum class StopReason {
  kGainExhausted,  ///< nothing reachable promises more (Eq. 3.8)
  kSurfaceFlat,    ///< sweeps in a row brought next to no surface, whatever views promise
  kExplored,       ///< of scenes to explore: nothing reachable promises more
  kRouteDone,      ///< all views of a given route were visited
  kBlockedNarrow,  ///< what promises more lies beyond ways too narrow for the robot
  kScanBudget,
  kTimeBudget,
  kDistanceBudget,
  kOutOfReach,  ///< nothing of the object was seen, and no way leads nearer to it
  kNoCandidates,
  kFell,
  kStuck,
  kSignal,
  kError
};

/// The words that summary.json uses: "robot_fell", "gain_exhausted".
std::string_view NameOf(RunStatus status);
std::string_view NameOf(StopReason reason);
std::optional<RunStatus> RunStatusFromName(std::string_view name);
std::optional<StopReason> StopReasonFromName(std::string_view name);

/// Whether running the same thing again cannot change the outcome (completed, budget, robot_fell, stuck).
bool IsFinal(RunStatus status);
/// The exit code of a run: 0 for completed and budget, 130 for interrupted, else 1.
int ExitCodeOf(RunStatus status);

// Keys of summary.json in order: text, then numbers. A key without a value is left out.
// clang-format off
#define ATLAS_SUMMARY_TEXT(X) X(experiment) X(scene) X(robot) X(locomotion) X(terrain) X(localisation) X(odometry) X(mapper) X(planner) X(gain)
#define ATLAS_SUMMARY_TEXT_MORE(X) X(worth) X(deviations) X(version) X(commit) X(config_hash) X(scene_hash) X(robot_hash) X(render_backend) X(render_problem)
#define ATLAS_SUMMARY_NUMBERS(X)                                                                           \
  X(coverage) X(coverage_raw) X(coverage_outer) X(coverage_attainable) X(coverage_of_attainable)           \
  X(travel_distance_m) X(scans) X(sim_time_s) X(wall_time_s) X(real_time_factor)                           \
  X(nbv_time_s_mean) X(nbv_time_s_p95) X(integration_ms_mean) X(integration_ms_p95)                        \
  X(map_bytes) X(peak_rss_bytes) X(submaps) X(falls) X(collisions) X(footholds_off_solid) X(worst_foot_drop_m) X(blocked_ways)                                        \
  X(cloud_error_m_mean) X(cloud_error_m_p95) X(map_error_m_mean) X(map_completeness)                       \
  X(ate_m) X(ate_odometry_m) X(t50_s) X(t90_s) X(t95_s)                                                    \
  X(explored_volume_m3) X(explored_volume_attainable_m3) X(explored_of_attainable)
// clang-format on

/// `gain` is the information gain that the planner was given; `worth`, where that alone does not decide, says
/// what does; `deviations` (joined by "; ") where a run of the thesis's planner does otherwise than the
/// thesis. SI units; shares in [0, 1]. coverage: Eq. 3.9, aligned (coverage_raw: not); coverage_outer: by
/// returns from the outer side only (coverage.h). coverage_attainable: coverage_outer's ceiling;
/// coverage_of_attainable: the share of what is attainable that was covered from its outer side. t50_s,
/// t90_s, t95_s: simulated time at which coverage_of_attainable reached 0.50, 0.90 and 0.95. Numbers that
/// count (scans, bytes, falls) are written as integers.
struct RunSummary {
#define X(key) std::string key;
  ATLAS_SUMMARY_TEXT(X)
  ATLAS_SUMMARY_TEXT_MORE(X)
#undef X
  uint64_t seed = 0;
  RunStatus status = RunStatus::kInterrupted;
  StopReason stop_reason = StopReason::kSignal;
#define X(key) std::optional<double> key;
  ATLAS_SUMMARY_NUMBERS(X)
  X(miou)
#undef X
  std::optional<bool> returned_home;
  /// The last mission.flat_scans scans added less than mission.flat_coverage each: what the truth says of an
  /// ending that was decided without it.
  std::optional<bool> flat_by_truth;
  /// Ways too narrow that kept the mission from being completed, each "at (3.2, 1.0): 0.55 m wide, 0.62 m
  /// needed", by "; ".
  std::string blocked_at;
};

/// summary.json as text, keys in DESIGN.md's order.
std::string ToJson(const RunSummary& summary);
/// @param origin the file's name, for messages. @throws InputError for malformed JSON, a missing
/// `experiment`, `status` or `stop_reason`, an unknown one of these two or a value of the wrong type.
RunSummary SummaryFromJson(const std::string& text, const std::string& origin);

/// Reads `run_folder`/summary.json. @throws InputError when it is missing or bad.
RunSummary LoadRunSummary(const std::filesystem::path& run_folder);

}  // namespace atlas::experiments
