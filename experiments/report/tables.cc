#include "experiments/report/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/files.h"
#include "experiments/report/mapper_pairs.h"
#include "experiments/report/table_columns.h"

namespace atlas::experiments {
namespace fs = std::filesystem;
namespace {

using Use = Column::Use;

struct Row {
  const RunGroup* group = nullptr;
  std::optional<ThesisRow> thesis = std::nullopt;  ///< stands in place of a group
};

std::string CellOf(const Row& row, const Column& column) {
  if (!row.thesis) return column.Of(*row.group);
  return column.of_thesis == nullptr ? "" : column.of_thesis(*row.thesis);
}

/// The table's columns: those of its kind, and of the others those that a row has a value for.
std::vector<const Column*> ColumnsFor(const std::vector<Row>& rows, Use kind) {
  std::vector<const Column*> columns;
  for (const Column& column : TableColumns()) {
    const bool of_a_kind = column.use == Use::kGroups || column.use == Use::kRuns;
    const bool measured = std::any_of(rows.begin(), rows.end(), [&](const Row& row) {
      return row.group != nullptr && column.Of(*row.group) != kNotMeasured;
    });
    if (of_a_kind ? column.use == kind : column.use == Use::kAlways || measured) columns.push_back(&column);
  }
  return columns;
}

std::vector<std::string> Terms(const std::vector<const Column*>& columns, const std::vector<Row>& rows) {
  std::string terms;
  for (const Column* column : columns) {
    if (column->meaning.empty()) continue;
    const std::string name = column->heading.substr(0, column->heading.rfind(' '));
    terms += fmt::format("{}{}: {}", terms.empty() ? "" : "; ", name, column->meaning);
  }
  std::vector<std::string> notes = {terms};
  size_t most = 0;
  bool two = false;
  for (const Row& row : rows) {
    if (row.group == nullptr) continue;
    most = std::max(most, row.group->runs.size());
    two = two || row.group->runs.size() == 2;
  }
  if (most >= 3) {
    notes.push_back("a ± b: mean over seeds and half width of its 95 % confidence interval (t distribution)" +
                    std::string(two ? "; a [b, c]: of two seeds, both" : ""));
  } else if (two) {
    notes.push_back("a [b, c]: mean of two seeds, and both");
  }
  return notes;
}

/// The words of the summaries as columns behind the others.
void AppendWords(const std::vector<Row>& rows, TextTable* table) {
  for (const auto& [word, member] : SummaryWords()) {
    if (word == "planner" || word == "gain") continue;
    table->heading.emplace_back(word);
    table->left.push_back(true);
    for (size_t i = 0; i < rows.size(); ++i) {
      table->rows[i].push_back(rows[i].group == nullptr ? "" : rows[i].group->runs.front().summary.*member);
    }
  }
}

TextTable Assemble(const std::vector<Row>& rows, Use kind) {
  const std::vector<const Column*> columns = ColumnsFor(rows, kind);
  TextTable table;
  for (const Column* column : columns) {
    table.heading.push_back(column->heading);
    table.left.push_back(column->left);
  }
  const std::string* object = nullptr;
  for (const Row& row : rows) {
    if (row.group != nullptr) {
      if (object != nullptr && *object != row.group->object) table.rules_before.push_back(table.rows.size());
      object = &row.group->object;
    }
    std::vector<std::string>& cells = table.rows.emplace_back();
    for (const Column* column : columns) cells.push_back(CellOf(row, *column));
  }
  table.notes = Terms(columns, rows);
  return table;
}

TextTable WithWords(TextTable table, const std::vector<Row>& rows, const GroupedRuns& runs, Words words) {
  if (words == Words::kColumns) {
    AppendWords(rows, &table);
  } else {
    for (std::string& note : WordNotes(runs.groups)) table.notes.push_back(std::move(note));
  }
  table.notes.insert(table.notes.end(), runs.notes.begin(), runs.notes.end());
  return table;
}

}  // namespace

std::string MinutesSeconds(double seconds) {
  const long whole = std::lround(std::max(seconds, 0.0));
  return fmt::format("{:02d}:{:02d}", whole / 60, whole % 60);
}

TextTable GroupTable(const GroupedRuns& runs, Words words) {
  const std::vector<RunGroup>& groups = runs.groups;
  std::vector<Row> rows;
  for (size_t i = 0; i < groups.size(); ++i) {
    rows.push_back({.group = &groups[i]});
    const bool last_of_kind = i + 1 == groups.size() || groups[i + 1].object != groups[i].object ||
                              groups[i + 1].gain != groups[i].gain;
    const auto thesis = FindThesisRow(groups[i].object, groups[i].gain);
    if (last_of_kind && thesis) rows.push_back({.thesis = thesis});
  }
  return WithWords(Assemble(rows, Use::kGroups), rows, runs, words);
}

TextTable RunsTable(const GroupedRuns& runs, Words words) {
  std::vector<RunGroup> singles;
  for (const RunGroup& group : runs.groups) {
    for (const ReportedRun& run : group.runs) {
      singles.push_back({group.object, group.gain, group.planner, group.variant, group.settings, {run}});
    }
  }
  for (const ReportedRun& run : runs.left_out) {
    const RunSummary& s = run.summary;
    singles.push_back({ObjectOf(s), s.gain, s.planner, "(left out)", run.settings, {run}});
  }
  std::vector<Row> rows;
  for (const RunGroup& single : singles) rows.push_back({.group = &single});
  return WithWords(Assemble(rows, Use::kRuns), rows, runs, words);
}

TextTable StatisticsTable(const std::vector<RunGroup>& groups) {
  TextTable table;
  table.heading = {"object", "gain", "planner", "number", "runs", "mean", "stddev", "ci95", "min", "max"};
  table.left = {true, true, true, true, false, false, false, false, false, false};
  for (const RunGroup& g : groups) {
    for (const auto& [name, cell] : g.runs.front().summary.numbers.cells()) {
      const SampleStatistics s = g.Over(name);
      if (s.count == 0) continue;
      table.rows.push_back({g.object, g.gain, g.Method(), name, fmt::format("{}", s.count),
                            fmt::format("{:.6g}", s.mean), fmt::format("{:.6g}", s.stddev),
                            s.count > 1 ? fmt::format("{:.6g}", ConfidenceHalfWidth(s)) : "",
                            fmt::format("{:.6g}", s.min), fmt::format("{:.6g}", s.max)});
    }
  }
  return table;
}

std::string CoverageTable(const GroupedRuns& runs) {
  return ToTerminal(GroupTable(runs));
}

void WriteTables(const GroupedRuns& runs, const std::string& command, const fs::path& folder) {
  const TextTable table = GroupTable(runs);
  core::WriteFileAtomically(folder / "table.md", fmt::format("`{}`\n\n{}", command, ToMarkdown(table)));
  core::WriteFileAtomically(folder / "table.tex", ToLatex(table));
  core::WriteFileAtomically(folder / "table.csv", ToCsv(GroupTable(runs, Words::kColumns)));
  core::WriteFileAtomically(folder / "runs.csv", ToCsv(RunsTable(runs, Words::kColumns)));
  core::WriteFileAtomically(folder / "statistics.csv", ToCsv(StatisticsTable(runs.groups)));
  const TextTable pairs = MapperPairsTable(runs.groups);
  std::error_code error;
  fs::remove(folder / "pairs.md", error);
  if (!pairs.rows.empty()) core::WriteFileAtomically(folder / "pairs.md", ToMarkdown(pairs));
}

}  // namespace atlas::experiments
