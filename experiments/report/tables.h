// Result tables in the form of the thesis's Table 3.1, for the terminal, Markdown, CSV and LaTeX.
#pragma once

#include <string>
#include <vector>

#include "experiments/metrics/run_summary.h"
#include "experiments/metrics/statistics.h"

namespace atlas::experiments {

/// Cells of text, the first row the heading. Columns flagged `left` are aligned left, the others right.
struct TextTable {
  std::vector<std::string> heading;
  std::vector<bool> left;
  std::vector<std::vector<std::string>> rows;
  std::vector<size_t> rules_before;  ///< a line is drawn before these rows
};

/// Aligned columns; display width counts UTF-8 characters, not bytes.
std::string ToTerminal(const TextTable& table);
std::string ToMarkdown(const TextTable& table);
std::string ToCsv(const TextTable& table);
/// A booktabs tabular, special characters escaped.
std::string ToLatex(const TextTable& table);

/// Runs that differ in seed only.
struct RunGroup {
  std::string experiment, gain, planner, mapper, locomotion;
  std::string variant;  ///< further settings that tell groups of a sweep apart; often empty
  std::vector<RunSummary> runs;

  /// Statistics over the runs that have this number.
  SampleStatistics Over(std::optional<double> RunSummary::*number) const;
  int CountOf(RunStatus status) const;
};

/// A run and the settings that a sweep varied besides experiment, gain and planner.
struct LabelledRun {
  RunSummary summary;
  std::string variant;
};
/// Groups in order of first appearance.
std::vector<RunGroup> GroupRuns(const std::vector<LabelledRun>& runs);
std::vector<RunGroup> GroupRuns(const std::vector<RunSummary>& runs);

/// One row a group, mean ± spread over seeds where there are several, the thesis's row under each where it
/// has one.
TextTable GroupTable(const std::vector<RunGroup>& groups, bool with_thesis);
/// One row a run.
TextTable RunsTable(const std::vector<RunSummary>& runs);

/// The table that ends a run or a sweep in the terminal: GroupTable with the thesis's rows and a line on
/// terms.
std::string CoverageTable(const std::vector<RunSummary>& runs);
std::string CoverageTable(const std::vector<RunGroup>& groups);

/// Every number of summary.json over seeds, a line a group and number (for spreadsheets and statistics).
TextTable StatisticsTable(const std::vector<RunGroup>& groups);

/// "12:26" (minutes are not limited to two digits).
std::string MinutesSeconds(double seconds);

}  // namespace atlas::experiments
