// Falls, collisions and footholds; nothing where no physics runs.
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class Safety final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row* step, core::Row*) override {
    if (!scan.safety.measured) return;
    step->Set("falls", scan.safety.falls);
    step->Set("collisions", scan.safety.collisions);
    step->Set("shank_brushes", scan.safety.shank_brushes);
    step->Set("footholds", scan.safety.footholds);
    step->Set("footholds_off_solid", scan.safety.footholds_off_solid);
    step->Set("worst_foot_drop_m", scan.safety.worst_foot_drop_m);
  }
  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    if (!run.safety.measured) return;
    summary->Set("falls", run.safety.falls);
    summary->Set("collisions", run.safety.collisions);
    summary->Set("footholds_off_solid", run.safety.footholds_off_solid);
    summary->Set("worst_foot_drop_m", run.safety.worst_foot_drop_m);
  }
};

}  // namespace

MetricEntry SafetyMetric() {
  const core::Column falls = {"falls", "", "of the robot, so far"},
                     collisions = {"collisions", "", "of trunk and thighs with the scene, so far"},
                     off_solid = {"footholds_off_solid", "",
                                  "footholds with less than solid ground under them"},
                     drop = {"worst_foot_drop_m", "m", "greatest depth of a touch-down below its target", 4};
  return {.name = "safety",
          .doc = "falls, collisions and footholds, where physics runs",
          .steps = {falls,
                    collisions,
                    {"shank_brushes", "", "of shanks with the scene, so far"},
                    {"footholds", "", "placed so far"},
                    off_solid,
                    drop},
          .summary = {falls, collisions, off_solid, drop},
          .build = BuildMetric<Safety>};
}

}  // namespace atlas::experiments
