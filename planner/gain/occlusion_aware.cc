// Occlusion aware volumetric information (Isler 2016; thesis Eq. 3.3-3.5).
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

class OcclusionAware final : public RaySumGain {
 public:
  explicit OcclusionAware(double) : entropy_(EntropyTable::Instance()) {}

  double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd) const override {
    double visibility = 1.0, sum = 0.0;
    for (const mapping::RaySample& v : samples) {
      const Attenuation voxels = AttenuationOf(v);
      sum += visibility * voxels.visibility * entropy_(v.occupancy);  // Eq. 3.4
      visibility *= voxels.passed;                                    // Eq. 3.5
      if (visibility < kNegligibleVisibility) break;
    }
    return sum;
  }

 private:
  const EntropyTable& entropy_;
};

}  // namespace

GainEntry OcclusionAwareGain() {
  return {"occlusion_aware", "sum of visibility x entropy over all voxels (Isler 2016; thesis Eq. 3.3-3.5)",
          GainLaws{.at_most_occlusion_aware = true}, GainReads{.each_free = true}, BuildGain<OcclusionAware>};
}

}  // namespace atlas::planner
