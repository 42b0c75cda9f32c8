// How much of the true surface the cloud covers (thesis Eq. 3.9, docs/coverage.md), of how much could be had.
#include <algorithm>

#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class Coverage final : public Metric {
 public:
  explicit Coverage(const MetricSetup& setup) : setup_(setup) {}

  void OnScan(const JudgedScan& scan, core::Row* step, core::Row*) override {
    rounds_.push_back({scan.sim_time_s, scan.score.coverage, scan.score.of_attainable});
    step->Set("coverage_raw", scan.score.coverage_raw);
    step->Set("coverage", scan.score.coverage);
    step->Set("coverage_outer", scan.score.coverage_outer);
    step->Set("coverage_of_attainable", scan.score.of_attainable);
    step->Set("flat_by_truth", IsFlat());
  }

  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    summary->Set("coverage_attainable", run.attainable);
    if (rounds_.empty()) return;
    summary->Set("coverage", run.score.coverage);
    summary->Set("coverage_raw", run.score.coverage_raw);
    summary->Set("coverage_outer", run.score.coverage_outer);
    summary->Set("coverage_of_attainable", run.score.of_attainable);
    summary->Set("flat_by_truth", IsFlat());
    summary->Set("t50_s", TimeToReach(0.50));
    summary->Set("t90_s", TimeToReach(0.90));
    summary->Set("t95_s", TimeToReach(0.95));
  }

 private:
  struct Round {
    double sim_time_s, coverage;
    std::optional<double> of_attainable;
  };

  /// Whether the last scans added less than is worth while: what the truth says of an ending that was decided
  /// without it.
  bool IsFlat() const {
    const auto scans = static_cast<size_t>(setup_.flat_scans);
    if (rounds_.size() <= scans) return false;
    const double added = rounds_.back().coverage - rounds_[rounds_.size() - 1 - scans].coverage;
    return added < static_cast<double>(scans) * setup_.flat_coverage;
  }
  std::optional<double> TimeToReach(double share) const {
    const auto first = std::find_if(rounds_.begin(), rounds_.end(),
                                    [&](const Round& round) { return round.of_attainable >= share; });
    return first == rounds_.end() ? std::nullopt : std::optional(first->sim_time_s);
  }

  MetricSetup setup_;
  std::vector<Round> rounds_;
};

}  // namespace

MetricEntry CoverageMetric() {
  const core::Column raw = {"coverage_raw", "", "as coverage, without the rigid alignment"},
                     aligned = {"coverage", "",
                                "share of the truth with a return within the radius (Eq. 3.9)"},
                     outer = {"coverage_outer", "", "as coverage, by returns from the outer side only"},
                     share = {"coverage_of_attainable", "",
                              "share of what is attainable, from the outer side"},
                     flat = {"flat_by_truth", "",
                             "the truth's coverage has stopped growing; decides nothing"};
  return {
      .name = "coverage",
      .doc = "of the true surface (Eq. 3.9), from its outer side, of what is attainable",
      .steps = {raw, aligned, outer, share, flat},
      .summary = {aligned,
                  raw,
                  outer,
                  {"coverage_attainable", "", "ceiling of coverage_outer: sweeps from all reachable poses"},
                  share,
                  flat,
                  {"t50_s", "s", "simulated time until half of the attainable was covered"},
                  {"t90_s", "s", "likewise, 90 %"},
                  {"t95_s", "s", "likewise, 95 %"}},
      .build = [](const MetricSetup& setup) {
        return std::unique_ptr<Metric>(std::make_unique<Coverage>(setup));
      }};
}

}  // namespace atlas::experiments
