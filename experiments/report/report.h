// `atlas report`: tables, statistics, plots and one HTML page over run folders.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "experiments/metrics/run_recorder.h"
#include "experiments/report/svg_plot.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {

/// Collects the run folders at or below `folders` and writes table.{md,csv,tex}, runs.csv, statistics.csv,
/// coverage_<experiment>.svg and report.html to `out` (empty: the first folder), the table to `log`. Runs
/// whose summary cannot be read are named and left out. Returns 0.
/// @throws InputError when a folder is missing or none holds a readable run, or `out` cannot be written.
int RunReport(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& out,
              std::ostream& log);

/// A readable run with its curve.
struct ReportedRun {
  std::filesystem::path folder;
  RunSummary summary;
  CoverageCurve curve;
};

/// Mean coverage over the runs of each gain and planner against scans, with the spread (min to max) shaded. A
/// run that ended earlier keeps its last value.
std::string CoverageByScanPlot(const std::string& experiment, const std::vector<ReportedRun>& runs);
/// The same against simulated minutes.
std::string CoverageByTimePlot(const std::string& experiment, const std::vector<ReportedRun>& runs);

/// One page that needs no other file: tables and pictures inline.
std::string HtmlPage(const std::vector<ReportedRun>& runs, const std::vector<std::string>& skipped);

}  // namespace atlas::experiments
