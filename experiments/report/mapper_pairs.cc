#include "experiments/report/mapper_pairs.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace atlas::experiments {
namespace {

/// All that runs of one row share.
bool AreAlike(const RunWithCurve& a, const RunWithCurve& b) {
  return a.summary.experiment == b.summary.experiment && a.summary.gain == b.summary.gain &&
         a.summary.planner == b.summary.planner && a.variant == b.variant;
}

/// The mean of those that there are.
class Mean {
 public:
  void Add(double value) {
    sum_ += value;
    ++count_;
  }
  void AddRatio(std::optional<double> a, std::optional<double> b) {
    if (a && b && *b > 0.0) Add(*a / *b);
  }
  std::string Text(const char* format) const {
    return count_ > 0 ? fmt::format(fmt::runtime(format), sum_ / count_) : "-";
  }

 private:
  double sum_ = 0.0;
  int count_ = 0;
};

struct Row {
  explicit Row(const RunWithCurve* run) : first(run) {}

  const RunWithCurve* first;  ///< the others are like it
  int pairs = 0;
  Mean at_end, at_equal_scans, scans, integration, nbv;
};

void Add(const RunWithCurve& atlas, const RunWithCurve& octomap, Row* row) {
  const auto &a = atlas.curve.coverage, &b = octomap.curve.coverage;
  const size_t both = std::min(a.size(), b.size());
  ++row->pairs;
  row->at_end.Add(100.0 * (a.back() - b.back()));
  row->at_equal_scans.Add(100.0 * (a[both - 1] - b[both - 1]));
  row->scans.Add(static_cast<double>(a.size()) - static_cast<double>(b.size()));
  row->integration.AddRatio(atlas.summary.integration_ms_mean, octomap.summary.integration_ms_mean);
  row->nbv.AddRatio(atlas.summary.nbv_time_s_mean, octomap.summary.nbv_time_s_mean);
}

}  // namespace

TextTable MapperPairsTable(const std::vector<RunWithCurve>& runs) {
  std::vector<Row> rows;
  for (const RunWithCurve& atlas : runs) {
    if (atlas.summary.mapper != "se_atlas" || atlas.curve.coverage.empty()) continue;
    const auto octomap = std::find_if(runs.begin(), runs.end(), [&](const RunWithCurve& other) {
      return other.summary.mapper == "octomap" && !other.curve.coverage.empty() && AreAlike(atlas, other) &&
             atlas.summary.seed == other.summary.seed;
    });
    if (octomap == runs.end()) continue;
    auto row =
        std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return AreAlike(*r.first, atlas); });
    if (row == rows.end()) {
      rows.emplace_back(&atlas);
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
    const RunSummary& s = row.first->summary;
    table.rows.push_back(
        {s.experiment, s.gain, row.first->variant.empty() ? s.planner : s.planner + " " + row.first->variant,
         fmt::format("{}", row.pairs), row.at_end.Text("{:+.2f}"), row.at_equal_scans.Text("{:+.2f}"),
         row.scans.Text("{:+.1f}"), row.integration.Text("{:.2f}"), row.nbv.Text("{:.2f}")});
  }
  return table;
}

}  // namespace atlas::experiments
