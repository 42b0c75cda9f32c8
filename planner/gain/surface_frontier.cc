// Surface frontier: area of the unknown that a view would uncover, each patch counted once.
//
// A sum over rays rewards standing close, where one unknown patch takes many rays. What a scan can add to a
// surface is bounded by the surface: so this gain counts the unknown voxels that the view's rays enter first,
// down to a shallow depth, once each whatever the number of rays. What lies deeper is hidden if the frontier
// turns out to be a surface, and comes into view with the next scan if it does not.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"
#include "planner/gain/voxel_set.h"

namespace atlas::planner {
namespace {

/// A ray uncovers this much of an unknown run.
constexpr double kDepth_m = 0.10;

class SurfaceFrontier final : public SharedUnionGain {
 public:
  explicit SurfaceFrontier(double resolution_m) : voxel_m3_(resolution_m * resolution_m * resolution_m) {}

  void BeginViews() override { seen_.Clear(); }
  void AddRayToViews(std::span<const mapping::RaySample> samples, mapping::RayEnd, uint64_t views) override {
    double uncovered_m = 0.0;
    for (const mapping::RaySample& v : samples) {
      if (!IsUnknown(v.occupancy)) continue;
      seen_.Add(v.key, views);
      uncovered_m += v.length_m;
      if (uncovered_m >= kDepth_m) return;
    }
  }
  /// Volume of the uncovered shell over its depth.
  std::vector<double> FinishViews(size_t count) override {
    std::vector<double> gain;
    for (const size_t voxels : seen_.Count(count)) {
      gain.push_back(voxel_m3_ * static_cast<double>(voxels) / kDepth_m);
    }
    return gain;
  }

 private:
  double voxel_m3_;
  VoxelViews seen_;
};

}  // namespace

GainEntry SurfaceFrontierGain() {
  return {"surface_frontier",
          "square metres of unknown that the view uncovers first, each patch once (docs in its file)",
          GainLaws{}, BuildGain<SurfaceFrontier>};
}

}  // namespace atlas::planner
