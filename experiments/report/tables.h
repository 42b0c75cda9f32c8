// Result tables in the form of the thesis's Table 3.1, for the terminal, Markdown, CSV, LaTeX and HTML.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/report/run_groups.h"
#include "experiments/report/text_table.h"

namespace atlas::experiments {

/// Where the words of summary.json go (localisation, odometry, mapper, deviations, commit ...).
enum class Words { kNotes, kColumns };

/// One row a group: means, from three seeds on with the half width of their 95 % confidence interval. The
/// thesis's row stands under each kind where it has one. Columns that no row has a value for are left out.
TextTable GroupTable(const GroupedRuns& runs, Words words = Words::kNotes);
/// One row a run, those that no mean holds last.
TextTable RunsTable(const GroupedRuns& runs, Words words = Words::kNotes);

/// GroupTable for the terminal.
std::string CoverageTable(const GroupedRuns& runs);

/// Every number of summary.json over seeds, a line a group and number (for spreadsheets and statistics).
TextTable StatisticsTable(const std::vector<RunGroup>& groups);

/// Lines under a table of these groups: what the words of their summaries say, once where all agree, else by
/// the rows that they hold for.
std::vector<std::string> WordNotes(const std::vector<RunGroup>& groups);

/// Writes table.{md,csv,tex}, runs.csv, statistics.csv and, where two mappers ran the same seeds, pairs.md.
/// `command` is named above table.md. @throws InputError when the folder cannot be written.
void WriteTables(const GroupedRuns& runs, const std::string& command, const std::filesystem::path& folder);

/// "12:26" (minutes are not limited to two digits).
std::string MinutesSeconds(double seconds);

}  // namespace atlas::experiments
