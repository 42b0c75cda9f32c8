// How far the points of the cloud lie from the true surface.
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class CloudErrors final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row* step, core::Row*) override { Write(scan.score.error, step); }
  void Summarise(const JudgedRun& run, core::Row* summary) const override { Write(run.score.error, summary); }

 private:
  static void Write(const CloudError& error, core::Row* row) {
    if (error.points == 0) return;
    row->Set("cloud_error_m_mean", error.mean_m);
    row->Set("cloud_error_m_p95", error.p95_m);
  }
};

}  // namespace

MetricEntry CloudErrorMetric() {
  const std::vector<core::Column> columns = {
      {"cloud_error_m_mean", "m", "mean distance of the aligned cloud to the true surface"},
      {"cloud_error_m_p95", "m", "95 % of the cloud err by less"}};
  return {.name = "cloud_error",
          .doc = "distance of the cloud to the true surface",
          .steps = columns,
          .summary = columns,
          .build = BuildMetric<CloudErrors>};
}

}  // namespace atlas::experiments
