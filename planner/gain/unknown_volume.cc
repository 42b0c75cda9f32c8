// Unknown volume (nbvplanner, Bircher 2016): cubic metres of unknown voxels in view, each counted once.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"
#include "planner/gain/voxel_rays.h"

namespace atlas::planner {
namespace {

class UnknownVolume final : public SharedUnionGain {
 public:
  explicit UnknownVolume(double resolution_m) : voxel_m3_(resolution_m * resolution_m * resolution_m) {}

  void BeginViews(size_t count) override { met_.Clear(count); }
  /// Only a known surface hides what lies behind it: unknown voxels do not.
  void AddRayToViews(std::span<const mapping::RaySample> samples, mapping::RayEnd,
                     std::span<const double> weights) override {
    for (const mapping::RaySample& v : samples) {
      if (IsUnknown(v)) met_.Add(v.key, weights);
    }
  }
  std::vector<double> FinishViews() override {
    std::vector<double> gain(met_.views(), 0.0);
    for (size_t i = 0; i < met_.size(); ++i) {
      const std::span<const float> rays = met_.Rays(i);
      for (size_t v = 0; v < rays.size(); ++v) gain[v] += rays[v] > 0.0f ? voxel_m3_ : 0.0;
    }
    return gain;
  }

 private:
  double voxel_m3_;
  VoxelRays met_;
};

}  // namespace

GainEntry UnknownVolumeGain() {
  return {"unknown_volume", "volume of the unknown voxels in view, each once (nbvplanner, Bircher 2016)",
          GainLaws{}, GainReads{.each_unmeasured = true}, BuildGain<UnknownVolume>};
}

}  // namespace atlas::planner
