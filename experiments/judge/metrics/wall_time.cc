// What depends on the machine: wall-clock times and memory.
#include "core/resource_use.h"
#include "experiments/judge/metrics/entries.h"
#include "experiments/results/statistics.h"

namespace atlas::experiments {
namespace {

class WallTime final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row*, core::Row* times) override {
    const ScanTimes& t = scan.times;
    times->Set("nbv_time_s", t.nbv_time_s);
    times->Set("integration_ms", t.integration_ms);
    times->Set("terrain_ms", t.terrain_ms);
    times->Set("metrics_ms", t.metrics_ms);
    times->Set("sweep_wall_s", t.sweep_wall_s);
    times->Set("walk_wall_s", t.walk_wall_s);
    times->Set("wall_time_s", t.wall_time_s);
    times->Set("map_bytes", t.map_bytes);
    if (t.nbv_time_s > 0.0) nbv_s_.push_back(t.nbv_time_s);
    integration_ms_.push_back(t.integration_ms);
    map_bytes_ = t.map_bytes;
  }

  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    summary->Set("wall_time_s", run.wall_time_s);
    if (run.wall_time_s > 0.0) summary->Set("real_time_factor", run.sim_time_s / run.wall_time_s);
    if (!nbv_s_.empty()) {
      summary->Set("nbv_time_s_mean", Describe(nbv_s_).mean);
      summary->Set("nbv_time_s_p95", Percentile(nbv_s_, 0.95));
    }
    if (!integration_ms_.empty()) {
      summary->Set("integration_ms_mean", Describe(integration_ms_).mean);
      summary->Set("integration_ms_p95", Percentile(integration_ms_, 0.95));
      summary->Set("map_bytes", map_bytes_);
    }
    summary->Set("peak_rss_bytes", static_cast<size_t>(core::PeakResidentBytes()));
  }

 private:
  std::vector<double> nbv_s_, integration_ms_;
  size_t map_bytes_ = 0;
};

}  // namespace

MetricEntry WallTimeMetric() {
  return {.name = "wall_time",
          .doc = "wall-clock times and memory; they depend on the machine",
          .times = {{"nbv_time_s", "s", "of the decision: candidates, gains, costs, path", 4},
                    {"integration_ms", "ms",
                     "of the map alone, for all that it took since the scan before: walk and sweep", 2},
                    {"terrain_ms", "ms", "of the terrain map", 2},
                    {"metrics_ms", "ms", "of scoring", 2},
                    {"sweep_wall_s", "s", "of simulating the sweep", 4},
                    {"walk_wall_s", "s", "of simulating the walk that led here", 4},
                    {"wall_time_s", "s", "since the run began", 4},
                    {"map_bytes", "B", "that the map takes"}},
          .summary = {{"wall_time_s", "s", "of the mission"},
                      {"real_time_factor", "", "simulated over wall time"},
                      {"nbv_time_s_mean", "s", "of a decision"},
                      {"nbv_time_s_p95", "s", "likewise, 95th percentile"},
                      {"integration_ms_mean", "ms", "of the map alone, a scan with the walk that led there"},
                      {"integration_ms_p95", "ms", "likewise, 95th percentile"},
                      {"map_bytes", "B", "that the map takes"},
                      {"peak_rss_bytes", "B", "of the process"}},
          .build = BuildMetric<WallTime>};
}

}  // namespace atlas::experiments
