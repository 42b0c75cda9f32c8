// `atlas report`: tables, statistics, plots and one HTML page over run folders.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "experiments/report/run_groups.h"
#include "experiments/results/svg_plot.h"

namespace atlas::experiments {

/// Collects the run folders at or below `folders` and writes the tables (WriteTables), coverage_<object>.svg
/// and report.html to `out` (empty: the first folder), the table to `log`. Runs whose summary cannot be read
/// are named and left out. Returns 0.
/// @throws InputError when a folder is missing or none holds a readable run, or `out` cannot be written.
int RunReport(const std::vector<std::filesystem::path>& folders, const std::filesystem::path& out,
              std::ostream& log);

/// Mean coverage of each group of `object` against scans, the spread (least to greatest) shaded where it has
/// several runs. A run that ended earlier keeps its last value.
std::string CoverageByScanPlot(const std::string& object, const std::vector<RunGroup>& groups);
/// The same against simulated minutes.
std::string CoverageByTimePlot(const std::string& object, const std::vector<RunGroup>& groups);

/// What was mapped, in order of first appearance.
std::vector<std::string> ObjectsOf(const std::vector<RunGroup>& groups);

/// One page that needs no other file: tables and pictures inline.
std::string HtmlPage(const GroupedRuns& runs, const std::vector<std::string>& skipped);

}  // namespace atlas::experiments
