// Runs gathered by their whole configuration, so that a row or a curve never mixes two of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/identity/run_settings.h"
#include "experiments/results/run_recorder.h"
#include "experiments/results/run_summary.h"
#include "experiments/results/statistics.h"

namespace atlas::experiments {

/// A number of summary.json.

/// A run as tables take it.
struct ReportedRun {
  std::filesystem::path folder;
  RunSummary summary;
  RunSettings settings = {};  ///< all that tells its configuration from others, the commit among it
  CoverageCurve curve = {};
};

/// The summary and the resolved parameters (config.yaml, where there is one) of a run folder; no curve.
/// @throws InputError for files that cannot be read.
ReportedRun LoadReportedRun(const std::filesystem::path& folder);
/// A run by its summary alone: settings are what it names.
ReportedRun RunOfSummary(const RunSummary& summary);

/// Runs that differ in seed only.
struct RunGroup {
  std::string object, gain, planner;
  std::string variant = "";  ///< "mapper=octomap": what tells it from groups of this object, gain, planner
  RunSettings settings = {};
  std::vector<ReportedRun> runs = {};

  /// Statistics over the runs that have this number.
  SampleStatistics Over(const std::string& number) const;
  int CountOf(RunStatus status) const;
  /// The planner's name and the variant.
  std::string Method() const;
};

struct GroupedRuns {
  std::vector<RunGroup> groups;       ///< in order of first appearance, runs of one object together
  std::vector<ReportedRun> left_out;  ///< interrupted, failed, or the repetition of a seed
  std::vector<std::string> notes;     ///< what was left out, and settings that differ but are in no label
};

/// Groups by all settings, labels the groups, and leaves out what no mean may hold. A single run is kept
/// whatever its status.
GroupedRuns GroupRuns(const std::vector<ReportedRun>& runs);

/// What was mapped: the experiment, or the scene that was put in its place.
std::string ObjectOf(const RunSummary& run);

}  // namespace atlas::experiments
