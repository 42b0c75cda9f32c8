// How far the robot was from where it believed to be, and what loops made of that.
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class Trajectory final : public Metric {
 public:
  void OnScan(const JudgedScan&, core::Row*, core::Row*) override {}
  void Summarise(const JudgedRun& run, core::Row* summary) const override {
    if (run.odometry && run.odometry->revolutions > 0) {
      const auto revolutions = static_cast<double>(run.odometry->revolutions);
      summary->Set("odometry_lost", static_cast<double>(run.odometry->lost) / revolutions);
      summary->Set("odometry_degenerate", static_cast<double>(run.odometry->degenerate) / revolutions);
    }
    if (!run.trajectory) return;
    summary->Set("keyframes", run.trajectory->keyframes);
    summary->Set("ate_odometry_m", run.trajectory->odometry_m);
    summary->Set("ate_believed_m", run.trajectory->believed_m);
    summary->Set("ate_m", run.trajectory->corrected_m);
    summary->Set("submaps", run.submaps);
  }
};

}  // namespace

MetricEntry TrajectoryMetric() {
  return {.name = "trajectory",
          .doc = "absolute trajectory error over keyframes, before and after loops",
          .summary = {{"keyframes", "", "places that the localiser keeps"},
                      {"ate_odometry_m", "m",
                       "trajectory error of odometry alone (root mean square); lidar: of its prior"},
                      {"ate_believed_m", "m", "of where the robot believed to be at the time"},
                      {"ate_m", "m", "of where it believes by now to have been"},
                      {"submaps", "", "rigid parts of the map"},
                      {"odometry_lost", "", "share of revolutions that scan matching could not place"},
                      {"odometry_degenerate", "", "share that did not fix all directions: along corridors"}},
          .build = BuildMetric<Trajectory>};
}

}  // namespace atlas::experiments
