// Unobserved voxel information (Isler 2016): occlusion aware, over unknown voxels only.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

class UnobservedVoxel final : public RaySumGain {
 public:
  explicit UnobservedVoxel(double) : entropy_(EntropyTable::Instance()) {}

  double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd) const override {
    double visibility = 1.0, sum = 0.0;
    for (const mapping::RaySample& v : samples) {
      const Attenuation voxels = AttenuationOf(v);
      if (IsUnknown(v)) sum += visibility * voxels.visibility * entropy_(v.occupancy);
      visibility *= voxels.passed;  // Eq. 3.5, over all voxels passed
      if (visibility < kNegligibleVisibility) break;
    }
    return sum;
  }

 private:
  const EntropyTable& entropy_;
};

}  // namespace

GainEntry UnobservedVoxelGain() {
  return {"unobserved_voxel", "sum of visibility x entropy over unknown voxels (Isler 2016)",
          GainLaws{.at_most_occlusion_aware = true}, GainReads{.each_free = true},
          BuildGain<UnobservedVoxel>};
}

}  // namespace atlas::planner
