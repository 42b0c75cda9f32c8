// Unknown volume (nbvplanner, Bircher 2016): cubic metres of unknown voxels in view, each counted once.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"
#include "planner/gain/voxel_set.h"

namespace atlas::planner {
namespace {

class UnknownVolume final : public Gain {
 public:
  explicit UnknownVolume(double resolution_m) : voxel_m3_(resolution_m * resolution_m * resolution_m) {}

  void BeginView() override { seen_.Clear(); }
  /// Only a known surface hides what lies behind it: unknown voxels do not.
  void AddRay(std::span<const mapping::RaySample> samples, mapping::RayEnd, double weight) override {
    if (weight <= 0.0) return;
    for (const mapping::RaySample& v : samples) {
      if (IsUnknown(v.occupancy)) seen_.Insert(v.key);
    }
  }
  double FinishView() override { return voxel_m3_ * static_cast<double>(seen_.size()); }

 private:
  double voxel_m3_;
  VoxelSet seen_;
};

}  // namespace

GainEntry UnknownVolumeGain() {
  return {"unknown_volume", "volume of the unknown voxels in view, each once (nbvplanner, Bircher 2016)",
          GainLaws{}, BuildGain<UnknownVolume>};
}

}  // namespace atlas::planner
