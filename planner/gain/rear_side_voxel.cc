// Rear side voxel count (Isler 2016): rays that strike a known surface from behind.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

class RearSideVoxel final : public RaySumGain {
 public:
  explicit RearSideVoxel(double) {}

  double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd end) const override {
    if (end != mapping::RayEnd::kOccupied || samples.size() < 2) return 0.0;
    return IsUnknown(samples[samples.size() - 2]) ? 1.0 : 0.0;
  }
};

}  // namespace

GainEntry RearSideVoxelGain() {
  return {"rear_side_voxel", "rays whose occupied end follows an unknown voxel (Isler 2016)", GainLaws{},
          GainReads{}, BuildGain<RearSideVoxel>};
}

}  // namespace atlas::planner
