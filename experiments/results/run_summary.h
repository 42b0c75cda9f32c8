// What one run comes to: the flat keys of summary.json. Its words are written and read through one list, so
// that they cannot disagree; its numbers are what metrics declare.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/table.h"

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

// The words of summary.json, in order. A key without a value is left out.
// clang-format off
#define ATLAS_SUMMARY_TEXT(X) X(experiment) X(scene) X(robot) X(locomotion) X(terrain) X(localisation) X(odometry) X(mapper) X(planner) X(gain)
#define ATLAS_SUMMARY_TEXT_MORE(X) X(worth) X(deviations) X(version) X(commit) X(config_hash) X(scene_hash) X(robot_hash) X(render_backend) X(render_problem)
// clang-format on

/// `gain` is the information gain that the planner was given; `worth`, where that alone does not decide, says
/// what does; `deviations` (joined by "; ") where a run of the thesis's planner does otherwise than the
/// thesis.
struct RunSummary {
#define X(key) std::string key;
  ATLAS_SUMMARY_TEXT(X)
  ATLAS_SUMMARY_TEXT_MORE(X)
#undef X
  uint64_t seed = 0;
  RunStatus status = RunStatus::kInterrupted;
  StopReason stop_reason = StopReason::kSignal;
  /// Ways too narrow that kept the mission from being completed, each "at (3.2, 1.0): 0.55 m wide, 0.62 m
  /// needed", by "; ".
  std::string blocked_at;
  /// What metrics measured (judge/metric.h, `atlas list metrics`): SI units, shares in [0, 1].
  core::Row numbers;

  /// Nothing where it was not measured.
  std::optional<double> Number(const std::string& key) const {
    return numbers.Number(key);
  }
};

/// summary.json as text: words, then numbers in the order in which they were set. @pre `numbers` holds no
/// words; they throw std::logic_error.
std::string ToJson(const RunSummary& summary);
/// @param origin the file's name, for messages. @throws InputError for malformed JSON, a missing
/// `experiment`, `status` or `stop_reason`, an unknown one of these two or a value of the wrong type.
RunSummary SummaryFromJson(const std::string& text, const std::string& origin);

/// Reads `run_folder`/summary.json. @throws InputError when it is missing or bad.
RunSummary LoadRunSummary(const std::filesystem::path& run_folder);

}  // namespace atlas::experiments
