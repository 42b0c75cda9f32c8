// Where the robot scanned, when, and how far it walked.
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class Progress final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row* step, core::Row* times) override {
    const core::Vec3& p = scan.T_map_base.translation();
    step->Set("scan", scan.scan);
    step->Set("sim_time_s", scan.sim_time_s);
    step->Set("distance_m", scan.distance_m);
    step->Set("x_m", p.x());
    step->Set("y_m", p.y());
    step->Set("z_m", p.z());
    step->Set("yaw_rad", core::YawOf(scan.T_map_base.linear()));
    times->Set("scan", scan.scan);
  }
  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    summary->Set("travel_distance_m", run.distance_m);
    summary->Set("scans", run.scans);
    summary->Set("sim_time_s", run.sim_time_s);
  }
};

}  // namespace

MetricEntry ProgressMetric() {
  return {.name = "progress",
          .doc = "scans, simulated time, distance walked",
          .steps = {{"scan", "", "from 1"},
                    {"sim_time_s", "s", "simulated, at the end of the sweep", 4},
                    {"distance_m", "m", "walked so far by the true base", 4},
                    {"x_m", "m", "of the base in the map, as the robot believed", 4},
                    {"y_m", "m", "likewise", 4},
                    {"z_m", "m", "likewise", 4},
                    {"yaw_rad", "rad", "likewise", 5}},
          .times = {{"scan", "", "from 1"}},
          .summary = {{"travel_distance_m", "m", "walked by the true base"},
                      {"scans", "", "sweeps that a plan followed: rows of steps.csv"},
                      {"sim_time_s", "s", "simulated"}},
          .build = BuildMetric<Progress>};
}

}  // namespace atlas::experiments
