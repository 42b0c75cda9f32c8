#include "experiments/report/table_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "experiments/judge/metric.h"
#include "experiments/report/tables.h"

namespace atlas::experiments {
namespace {

std::string Interval(const RunGroup& group, const std::string& name, double scale, int decimals) {
  return MeanWithInterval(group.Over(name),
                          [=](double value) { return fmt::format("{:.{}f}", scale * value, decimals); });
}

std::string Mean(const RunGroup& group, const std::string& name, double scale, int decimals) {
  const SampleStatistics s = group.Over(name);
  return s.count == 0 ? kNotMeasured : fmt::format("{:.{}f}", scale * s.mean, decimals);
}

/// Falls and collisions are summed over seeds: one is one too many.
std::string Total(const RunGroup& group, const std::string& name) {
  double sum = 0.0;
  bool measured = false;
  for (const ReportedRun& run : group.runs) {
    const auto number = run.summary.Number(name);
    sum += number.value_or(0.0);
    measured = measured || number;
  }
  return measured ? fmt::format("{:.0f}", sum) : kNotMeasured;
}

/// Greatest over seeds: the worst is what matters.
std::string Worst(const RunGroup& group, const std::string& name, double scale, int decimals) {
  const SampleStatistics s = group.Over(name);
  return s.count == 0 ? kNotMeasured : fmt::format("{:.{}f}", scale * s.max, decimals);
}

/// "completed (gain_exhausted)" of one run, "4 completed (gain_exhausted), 1 stuck (no_candidates)" of more.
std::string StatusOf(const RunGroup& group) {
  std::map<std::pair<RunStatus, StopReason>, int> counts;
  for (const ReportedRun& run : group.runs) ++counts[{run.summary.status, run.summary.stop_reason}];
  std::string text;
  for (const auto& [ending, count] : counts) {
    if (!text.empty()) text += ", ";
    if (group.runs.size() > 1) text += fmt::format("{} ", count);
    text += fmt::format("{} ({})", NameOf(ending.first), NameOf(ending.second));
  }
  return text;
}

using Use = Column::Use;

/// A number's meaning as its metric declares it.
std::string MeaningOf(const std::string& number) {
  for (const core::Column& column : SummaryColumns()) {
    if (column.name == number) return column.meaning;
  }
  return "";
}

std::vector<Column> WhoRan() {
  using Group = const RunGroup&;
  using Number = const std::string&;
  return {{"object", "", true, Use::kAlways, "", [](Group g, Number) { return g.object; },
           [](const ThesisRow& t) { return fmt::format("  thesis, Table {}", t.table); }},
          {"gain", "", true, Use::kAlways, "", [](Group g, Number) { return g.gain; },
           [](const ThesisRow& t) { return std::string(t.gain); }},
          {"planner", "", true, Use::kAlways, "", [](Group g, Number) { return g.Method(); }}};
}

std::vector<Column> Coverages() {
  const auto percent = [](const RunGroup& g, const std::string& n) { return Interval(g, n, 100.0, 2); };
  const auto millimetres = [](const RunGroup& g, const std::string& n) { return Interval(g, n, 1e3, 1); };
  return {{"c_p %", "coverage, thesis Eq. 3.9 (aligned)", false, Use::kAlways, "coverage", percent,
           [](const ThesisRow& t) { return fmt::format("{:.2f}", t.coverage_percent); }},
          {"c_outer %", "as c_p, by returns from the outer side of the surface only", false,
           Use::kWhereMeasured, "coverage_outer", percent},
          {"attainable %", "the ceiling of c_outer: sweeps from all reachable poses, noise-free", false,
           Use::kAlways, "coverage_attainable",
           [](const RunGroup& g, const std::string& n) { return Mean(g, n, 100.0, 1); }},
          {"of attainable %", "", false, Use::kAlways, "coverage_of_attainable", percent},
          {"error mm", MeaningOf("cloud_error_m_mean"), false, Use::kWhereMeasured, "cloud_error_m_mean",
           millimetres},
          {"p95 mm", MeaningOf("cloud_error_m_p95"), false, Use::kWhereMeasured, "cloud_error_m_p95",
           millimetres},
          {"explored m3", MeaningOf("explored_volume_m3"), false, Use::kWhereMeasured, "explored_volume_m3",
           [](const RunGroup& g, const std::string& n) { return Interval(g, n, 1.0, 1); }},
          {"of attainable m3 %", "", false, Use::kWhereMeasured, "explored_of_attainable", percent}};
}

std::vector<Column> Efforts() {
  using Group = const RunGroup&;
  using Number = const std::string&;
  return {
      {"d_t m", "distance walked", false, Use::kAlways, "travel_distance_m",
       [](Group g, Number n) { return Interval(g, n, 1.0, 2); },
       [](const ThesisRow& t) { return fmt::format("{:.2f}", t.travel_distance_m); }},
      {"n_s", "scans", false, Use::kAlways, "scans",
       [](Group g, Number n) { return Interval(g, n, 1.0, g.runs.size() > 1 ? 1 : 0); },
       [](const ThesisRow& t) { return fmt::format("{}", t.scans); }},
      {"t_all", "simulated time", false, Use::kAlways, "sim_time_s",
       [](Group g, Number n) { return MeanWithInterval(g.Over(n), MinutesSeconds); },
       [](const ThesisRow& t) { return MinutesSeconds(t.time_s); }},
      {"t_nbv s", "wall time a decision", false, Use::kAlways, "nbv_time_s_mean",
       [](Group g, Number n) { return Interval(g, n, 1.0, 2); },
       [](const ThesisRow& t) { return fmt::format("{:.2f}", t.nbv_time_s); }},
      {"RTF", MeaningOf("real_time_factor"), false, Use::kAlways, "real_time_factor",
       [](Group g, Number n) { return Interval(g, n, 1.0, 1); }},
  };
}

std::vector<Column> Endings() {
  using Group = const RunGroup&;
  using Number = const std::string&;
  return {
      {"falls", "", false, Use::kAlways, "falls", Total},
      {"collisions", "", false, Use::kAlways, "collisions", Total},
      {"drop cm", MeaningOf("worst_foot_drop_m"), false, Use::kWhereMeasured, "worst_foot_drop_m",
       [](Group g, Number n) { return Worst(g, n, 100.0, 1); }},
      {"runs", "", false, Use::kGroups, "", [](Group g, Number) { return fmt::format("{}", g.runs.size()); }},
      {"seed", "", false, Use::kRuns, "",
       [](Group g, Number) { return fmt::format("{}", g.runs.front().summary.seed); }},
      {"status", "", true, Use::kAlways, "", [](Group g, Number) { return StatusOf(g); }}};
}

}  // namespace

std::string MeanWithInterval(const SampleStatistics& s, const std::function<std::string(double)>& text) {
  if (s.count == 0) return kNotMeasured;
  if (s.count == 1) return text(s.mean);
  if (s.count == 2) return fmt::format("{} [{}, {}]", text(s.mean), text(s.min), text(s.max));
  std::string half_width = text(ConfidenceHalfWidth(s));
  if (half_width.starts_with('+')) half_width.erase(0, 1);  // of a difference's format
  return fmt::format("{} ± {}", text(s.mean), half_width);
}

const std::vector<Column>& TableColumns() {
  static const std::vector<Column> columns = [] {
    std::vector<Column> all;
    for (auto* part : {WhoRan, Coverages, Efforts, Endings}) {
      for (Column& column : part()) all.push_back(std::move(column));
    }
    return all;
  }();
  return columns;
}

const std::vector<std::pair<std::string_view, std::string RunSummary::*>>& SummaryWords() {
  static const std::vector<std::pair<std::string_view, std::string RunSummary::*>> words = {
#define X(key) {#key, &RunSummary::key},
      ATLAS_SUMMARY_TEXT(X) ATLAS_SUMMARY_TEXT_MORE(X)
#undef X
  };
  return words;
}

bool IsColumnOrHash(std::string_view word) {
  return word == "experiment" || word == "scene" || word == "planner" || word == "gain" ||
         word.ends_with("_hash");
}

}  // namespace atlas::experiments
