// Surface frontier: area of never measured space that a view would uncover first, each patch counted once.
//
// A sum over rays rewards standing close, where one unknown patch takes many rays; yet what a scan can add to
// a surface is bounded by the surface. So this gain counts the unmeasured voxels that the view's rays enter
// first, down to a shallow depth: what lies deeper is hidden if the frontier turns out to be a surface, and
// comes into view with the next scan if it does not. A voxel counts in full once enough sensor rays meet it
// for the mapper to decide what it is, so that far views, and headings that a roll hardly widens, promise no
// more than they bring. Voxels that were measured and stay undecided (edges that some rays hit and others
// pass) are not counted: more scans do not decide them.
#include <cmath>

#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"
#include "planner/gain/voxel_rays.h"

namespace atlas::planner {
namespace {

/// A ray uncovers this much of a run of unmeasured voxels.
constexpr double kDepth_m = 0.30;
/// Sensor rays through a voxel for 63 % of its credit.
constexpr double kEnoughRays = 6.0;

bool Unmeasured(float p) {
  return std::abs(p - 0.5f) < 1e-3f;
}

class SurfaceFrontier final : public SharedUnionGain {
 public:
  explicit SurfaceFrontier(double resolution_m)
      : patch_m2_(resolution_m * resolution_m * resolution_m / kDepth_m) {}

  void BeginViews(size_t count) override { met_.Clear(count); }

  void AddRayToViews(std::span<const mapping::RaySample> samples, mapping::RayEnd,
                     std::span<const double> weights) override {
    double uncovered_m = 0.0;
    for (const mapping::RaySample& v : samples) {
      if (Unmeasured(v.occupancy)) {
        met_.Add(v.key, weights);
        uncovered_m += v.length_m;
        if (uncovered_m >= kDepth_m) return;
      } else if (v.occupancy > 0.5f) {
        return;  // more likely a surface than not
      }
    }
  }

  std::vector<double> FinishViews() override {
    std::vector<double> gain(met_.views(), 0.0);
    for (size_t i = 0; i < met_.size(); ++i) {
      const std::span<const float> rays = met_.Rays(i);
      for (size_t v = 0; v < rays.size(); ++v) {
        if (rays[v] > 0.0f) gain[v] -= patch_m2_ * std::expm1(-static_cast<double>(rays[v]) / kEnoughRays);
      }
    }
    return gain;
  }

 private:
  double patch_m2_;
  VoxelRays met_;
};

}  // namespace

GainEntry SurfaceFrontierGain() {
  return {"surface_frontier",
          "square metres of unmeasured space that the view uncovers first, each patch once", GainLaws{},
          GainReads{.each_unmeasured = true}, BuildGain<SurfaceFrontier>};
}

}  // namespace atlas::planner
