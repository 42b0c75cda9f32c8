#include "experiments/report/tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "experiments/report/thesis_anchors.h"

namespace atlas::experiments {
namespace {

using Number = std::optional<double> RunSummary::*;

/// "83.76" or "83.76 ± 0.40"; "-" where no run has the number.
std::string MeanAndSpread(const SampleStatistics& s, double scale, int decimals) {
  if (s.count == 0) return "-";
  if (s.count == 1) return fmt::format("{:.{}f}", scale * s.mean, decimals);
  return fmt::format("{:.{}f} ± {:.{}f}", scale * s.mean, decimals, scale * s.stddev, decimals);
}

std::string MeanOf(const SampleStatistics& s, double scale, int decimals) {
  return s.count == 0 ? "-" : fmt::format("{:.{}f}", scale * s.mean, decimals);
}

std::string TimeAndSpread(const SampleStatistics& s) {
  if (s.count == 0) return "-";
  return s.count == 1 ? MinutesSeconds(s.mean)
                      : fmt::format("{} ± {}", MinutesSeconds(s.mean), MinutesSeconds(s.stddev));
}

/// Falls and collisions are summed over seeds: one is one too many.
std::string TotalOf(const RunGroup& group, Number number) {
  double sum = 0.0;
  for (const RunSummary& run : group.runs) sum += (run.*number).value_or(0.0);
  return fmt::format("{:.0f}", sum);
}

std::string StatusOf(const RunGroup& group) {
  if (group.runs.size() == 1) {
    return fmt::format("{} ({})", NameOf(group.runs[0].status), NameOf(group.runs[0].stop_reason));
  }
  std::string text;
  for (int i = 0; i <= static_cast<int>(RunStatus::kFailed); ++i) {
    const int count = group.CountOf(static_cast<RunStatus>(i));
    if (count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, NameOf(static_cast<RunStatus>(i)));
  }
  return text;
}

std::string PlannerOf(const RunGroup& group) {
  std::string text = group.planner;
  if (!group.variant.empty()) text += " " + group.variant;
  if (!group.locomotion.empty() && group.locomotion != "trot") text += " [" + group.locomotion + "]";
  return text;
}

std::vector<std::string> GroupRow(const RunGroup& g) {
  return {g.experiment,
          g.gain,
          PlannerOf(g),
          MeanAndSpread(g.Over(&RunSummary::coverage), 100.0, 2),
          MeanOf(g.Over(&RunSummary::coverage_attainable), 100.0, 1),
          MeanAndSpread(g.Over(&RunSummary::coverage_of_attainable), 100.0, 2),
          MeanAndSpread(g.Over(&RunSummary::travel_distance_m), 1.0, 2),
          MeanAndSpread(g.Over(&RunSummary::scans), 1.0, g.runs.size() > 1 ? 1 : 0),
          TimeAndSpread(g.Over(&RunSummary::sim_time_s)),
          MeanAndSpread(g.Over(&RunSummary::nbv_time_s_mean), 1.0, 2),
          MeanAndSpread(g.Over(&RunSummary::real_time_factor), 1.0, 1),
          TotalOf(g, &RunSummary::falls),
          TotalOf(g, &RunSummary::collisions),
          fmt::format("{}", g.runs.size()),
          StatusOf(g)};
}

/// What was mapped: the experiment, or the scene that was put in its place.
std::string ObjectOf(const RunSummary& run) {
  if (run.scene.empty() || run.scene == run.experiment) return run.experiment;
  return std::filesystem::path(run.scene).stem().string();
}

std::vector<std::string> ThesisCells(const ThesisRow& row) {
  return {fmt::format("  thesis, Table {}", row.table),
          std::string(row.gain),
          "",
          fmt::format("{:.2f}", row.coverage_percent),
          "",
          "",
          fmt::format("{:.2f}", row.travel_distance_m),
          fmt::format("{}", row.scans),
          MinutesSeconds(row.time_s),
          fmt::format("{:.2f}", row.nbv_time_s),
          "",
          "",
          "",
          "",
          ""};
}

/// Explored volume, a line a group that has one.
std::string VolumeLines(const std::vector<RunGroup>& groups) {
  std::string lines;
  for (const RunGroup& g : groups) {
    const SampleStatistics explored = g.Over(&RunSummary::explored_volume_m3);
    if (explored.count == 0) continue;
    lines += fmt::format("{}: explored {} m3 of {} m3 attainable ({} %)\n", g.experiment,
                         MeanAndSpread(explored, 1.0, 1),
                         MeanOf(g.Over(&RunSummary::explored_volume_attainable_m3), 1.0, 1),
                         MeanAndSpread(g.Over(&RunSummary::explored_of_attainable), 100.0, 2));
  }
  return lines;
}

TextTable EmptyGroupTable() {
  TextTable table;
  table.heading = {"object",     "gain", "planner", "c_p %",   "attainable %", "of attainable %",
                   "d_t m",      "n_s",  "t_all",   "t_nbv s", "RTF",          "falls",
                   "collisions", "runs", "status"};
  table.left = {true,  true,  true,  false, false, false, false, false,
                false, false, false, false, false, false, true};
  return table;
}

}  // namespace

std::string MinutesSeconds(double seconds) {
  const long whole = std::lround(std::max(seconds, 0.0));
  return fmt::format("{:02d}:{:02d}", whole / 60, whole % 60);
}

SampleStatistics RunGroup::Over(Number number) const {
  std::vector<double> values;
  for (const RunSummary& run : runs) {
    if (run.*number) values.push_back(*(run.*number));
  }
  return Describe(values);
}

int RunGroup::CountOf(RunStatus status) const {
  return static_cast<int>(
      std::count_if(runs.begin(), runs.end(), [&](const RunSummary& run) { return run.status == status; }));
}

std::vector<RunGroup> GroupRuns(const std::vector<LabelledRun>& runs) {
  std::vector<RunGroup> groups;
  for (const auto& [run, variant] : runs) {
    const auto same = [&](const RunGroup& g) {
      return g.experiment == ObjectOf(run) && g.gain == run.gain && g.planner == run.planner &&
             g.mapper == run.mapper && g.locomotion == run.locomotion && g.variant == variant;
    };
    auto group = std::find_if(groups.begin(), groups.end(), same);
    if (group == groups.end()) {
      groups.push_back({ObjectOf(run), run.gain, run.planner, run.mapper, run.locomotion, variant, {}});
      group = groups.end() - 1;
    }
    group->runs.push_back(run);
  }
  return groups;
}

std::vector<RunGroup> GroupRuns(const std::vector<RunSummary>& runs) {
  std::vector<LabelledRun> labelled;
  for (const RunSummary& run : runs) labelled.push_back({run, ""});
  return GroupRuns(labelled);
}

TextTable GroupTable(const std::vector<RunGroup>& groups, bool with_thesis) {
  TextTable table = EmptyGroupTable();
  for (size_t i = 0; i < groups.size(); ++i) {
    if (i > 0 && groups[i].experiment != groups[i - 1].experiment)
      table.rules_before.push_back(table.rows.size());
    table.rows.push_back(GroupRow(groups[i]));
    const bool last_of_kind = i + 1 == groups.size() || groups[i + 1].experiment != groups[i].experiment ||
                              groups[i + 1].gain != groups[i].gain;
    const auto thesis = FindThesisRow(groups[i].experiment, groups[i].gain);
    if (with_thesis && last_of_kind && thesis) table.rows.push_back(ThesisCells(*thesis));
  }
  return table;
}

TextTable RunsTable(const std::vector<RunSummary>& runs) {
  TextTable table = EmptyGroupTable();
  table.heading[13] = "seed";
  for (const RunSummary& run : runs) {
    RunGroup group{ObjectOf(run), run.gain, run.planner, run.mapper, run.locomotion, "", {run}};
    table.rows.push_back(GroupRow(group));
    table.rows.back()[13] = fmt::format("{}", run.seed);
  }
  return table;
}

TextTable StatisticsTable(const std::vector<RunGroup>& groups) {
  TextTable table;
  table.heading = {"object", "gain", "planner", "number", "runs", "mean", "stddev", "min", "max"};
  table.left = {true, true, true, true, false, false, false, false, false};
  for (const RunGroup& g : groups) {
    const auto add = [&](const char* name, Number number) {
      const SampleStatistics s = g.Over(number);
      if (s.count == 0) return;
      table.rows.push_back({g.experiment, g.gain, PlannerOf(g), name, fmt::format("{}", s.count),
                            fmt::format("{:.6g}", s.mean), fmt::format("{:.6g}", s.stddev),
                            fmt::format("{:.6g}", s.min), fmt::format("{:.6g}", s.max)});
    };
#define X(key) add(#key, &RunSummary::key);
    ATLAS_SUMMARY_NUMBERS(X)
#undef X
  }
  return table;
}

std::string CoverageTable(const std::vector<RunGroup>& groups) {
  return ToTerminal(GroupTable(groups, true)) + VolumeLines(groups) +
         "c_p: coverage, thesis Eq. 3.9 (aligned); attainable: its ceiling from all reachable poses; d_t: "
         "distance;\n"
         "n_s: scans; t_all: simulated time; t_nbv: wall time a decision; RTF: simulated over wall time.\n";
}

std::string CoverageTable(const std::vector<RunSummary>& runs) {
  return CoverageTable(GroupRuns(runs));
}

}  // namespace atlas::experiments
