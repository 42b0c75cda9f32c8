// How much of the space that can be reached is known, in scenes to explore.
#include <algorithm>

#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class ExploredSpace final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row* step, core::Row*) override {
    step->Set("explored_m3", scan.score.explored_m3);
  }
  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    if (!run.attainable_m3 || !run.score.explored_m3) return;
    summary->Set("explored_volume_m3", *run.score.explored_m3);
    summary->Set("explored_volume_attainable_m3", *run.attainable_m3);
    summary->Set("explored_of_attainable", *run.score.explored_m3 / std::max(1e-9, *run.attainable_m3));
  }
};

}  // namespace

MetricEntry ExploredSpaceMetric() {
  return {
      .name = "explored_space",
      .doc = "known volume of what can be seen, in scenes to explore",
      .steps = {{"explored_m3", "m^3", "known volume of what is attainable", 3}},
      .summary = {{"explored_volume_m3", "m^3", "known volume of what is attainable"},
                  {"explored_volume_attainable_m3", "m^3", "volume that sweeps from all reachable poses see"},
                  {"explored_of_attainable", "", "the first over the second"}},
      .build = BuildMetric<ExploredSpace>};
}

}  // namespace atlas::experiments
