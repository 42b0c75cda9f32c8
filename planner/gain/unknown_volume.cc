// Unknown volume (nbvplanner, Bircher 2016): cubic metres of unknown voxels in view, each counted once.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"
#include "planner/gain/voxel_set.h"

namespace atlas::planner {
namespace {

class UnknownVolume final : public SharedUnionGain {
 public:
  explicit UnknownVolume(double resolution_m) : voxel_m3_(resolution_m * resolution_m * resolution_m) {}

  void BeginViews() override { seen_.Clear(); }
  /// Only a known surface hides what lies behind it: unknown voxels do not.
  void AddRayToViews(std::span<const mapping::RaySample> samples, mapping::RayEnd, uint64_t views) override {
    for (const mapping::RaySample& v : samples) {
      if (IsUnknown(v.occupancy)) seen_.Add(v.key, views);
    }
  }
  std::vector<double> FinishViews(size_t count) override {
    std::vector<double> gain;
    for (const size_t voxels : seen_.Count(count)) gain.push_back(voxel_m3_ * static_cast<double>(voxels));
    return gain;
  }

 private:
  double voxel_m3_;
  VoxelViews seen_;
};

}  // namespace

GainEntry UnknownVolumeGain() {
  return {"unknown_volume", "volume of the unknown voxels in view, each once (nbvplanner, Bircher 2016)",
          GainLaws{}, BuildGain<UnknownVolume>};
}

}  // namespace atlas::planner
