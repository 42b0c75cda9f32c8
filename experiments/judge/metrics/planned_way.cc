// The way that was planned on the finished map, where one was asked for (thesis 4.10.8).
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class PlannedWay final : public Metric {
 public:
  void OnScan(const JudgedScan&, core::Row*, core::Row*) override {}
  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    if (run.planned_m) summary->Set("planned_m", *run.planned_m);
  }
};

}  // namespace

MetricEntry PlannedWayMetric() {
  return {.name = "planned_way",
          .doc = "the way between the places of mission.plan_after, on the map as it is at the end",
          .summary = {{"planned_m", "m", "length of that way; nothing where none was found"}},
          .build = BuildMetric<PlannedWay>};
}

}  // namespace atlas::experiments
