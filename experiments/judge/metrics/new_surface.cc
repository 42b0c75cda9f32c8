// What each sweep brought, as the robot sees it.
#include "experiments/judge/metrics/entries.h"

namespace atlas::experiments {
namespace {

class NewSurface final : public Metric {
 public:
  void OnScan(const JudgedScan& scan, core::Row* step, core::Row*) override {
    step->Set("cloud_points", scan.cloud_points);
    step->Set("new_surface_voxels", scan.new_surface_voxels);
  }
  void Summarise(const JudgedRun&, core::Row*) const override {}
};

}  // namespace

MetricEntry NewSurfaceMetric() {
  return {.name = "new_surface",
          .doc = "points and new voxels of each scan",
          .steps = {{"cloud_points", "", "of the filtered cloud since the scan before: walk and sweep"},
                    {"new_surface_voxels", "", "of the object, that returned for the first time"}},
          .build = BuildMetric<NewSurface>};
}

}  // namespace atlas::experiments
