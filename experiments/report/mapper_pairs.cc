#include "experiments/report/mapper_pairs.h"

#include <fmt/format.h>

#include <algorithm>

namespace atlas::experiments {
namespace {

bool ArePaired(const RunSummary& a, const RunSummary& b) {
  return a.experiment == b.experiment && a.gain == b.gain && a.planner == b.planner && a.robot == b.robot &&
         a.locomotion == b.locomotion && a.seed == b.seed;
}

/// Means over the pairs of one row.
struct Row {
  std::string experiment, gain, planner;
  int pairs = 0;
  double at_end = 0.0, at_equal_scans = 0.0, scans = 0.0, integration = 0.0, nbv = 0.0;
};

double Ratio(std::optional<double> a, std::optional<double> b) {
  return a && b && *b > 0.0 ? *a / *b : 0.0;
}

void Add(const RunWithCurve& atlas, const RunWithCurve& octomap, Row* row) {
  const auto &a = atlas.curve.coverage, &b = octomap.curve.coverage;
  const size_t both = std::min(a.size(), b.size());
  ++row->pairs;
  row->at_end += a.back() - b.back();
  row->at_equal_scans += a[both - 1] - b[both - 1];
  row->scans += static_cast<double>(a.size()) - static_cast<double>(b.size());
  row->integration += Ratio(atlas.summary.integration_ms_mean, octomap.summary.integration_ms_mean);
  row->nbv += Ratio(atlas.summary.nbv_time_s_mean, octomap.summary.nbv_time_s_mean);
}

}  // namespace

TextTable MapperPairsTable(const std::vector<RunWithCurve>& runs) {
  std::vector<Row> rows;
  for (const RunWithCurve& atlas : runs) {
    const RunSummary& s = atlas.summary;
    if (s.mapper != "se_atlas" || atlas.curve.coverage.empty()) continue;
    const auto octomap = std::find_if(runs.begin(), runs.end(), [&](const RunWithCurve& other) {
      return other.summary.mapper == "octomap" && !other.curve.coverage.empty() &&
             ArePaired(s, other.summary);
    });
    if (octomap == runs.end()) continue;
    auto row = std::find_if(rows.begin(), rows.end(), [&](const Row& r) {
      return r.experiment == s.experiment && r.gain == s.gain && r.planner == s.planner;
    });
    if (row == rows.end()) {
      rows.push_back({.experiment = s.experiment, .gain = s.gain, .planner = s.planner});
      row = rows.end() - 1;
    }
    Add(atlas, *octomap, &*row);
  }
  TextTable table{{"object", "gain", "planner", "pairs", "c_p at the end", "after equal scans", "scans",
                   "integration", "t_nbv"},
                  {true, true, true},
                  {},
                  {}};
  table.left.resize(table.heading.size(), false);
  for (const Row& row : rows) {
    const double n = row.pairs;
    table.rows.push_back({row.experiment, row.gain, row.planner, fmt::format("{}", row.pairs),
                          fmt::format("{:+.2f}", 100.0 * row.at_end / n),
                          fmt::format("{:+.2f}", 100.0 * row.at_equal_scans / n),
                          fmt::format("{:+.1f}", row.scans / n), fmt::format("{:.2f}", row.integration / n),
                          fmt::format("{:.2f}", row.nbv / n)});
  }
  return table;
}

}  // namespace atlas::experiments
