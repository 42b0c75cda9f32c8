// Occlusion aware information as an integral over length instead of a sum over voxels: what is confirmed
// (free or occupied) counts as certain, and an unknown stretch attenuates by its length, so that known-free
// space is worth nothing and the voxel size does not matter.
#include <cmath>

#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

/// The ray's transmission through a stretch s of occupancy p is (1 - p)^(s / kReference_m); its entropy
/// density is H(p) / kReference_m. At this voxel size a fully unknown ray is worth ln 2 / (-ln 0.5) = 1 nat.
constexpr double kReference_m = 0.05;

class OcclusionAwareNormalised final : public RaySumGain {
 public:
  explicit OcclusionAwareNormalised(double) : entropy_(EntropyTable::Instance()) {}

  double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd) const override {
    double visibility = 1.0, sum = 0.0;
    for (const mapping::RaySample& v : samples) {
      if (IsFree(v)) continue;   // certain: P = 0, H = 0
      if (IsOccupied(v)) break;  // certain, and nothing is seen behind it
      const double p = v.occupancy;
      const double extinction = -std::log1p(-p);
      const double passed = std::exp(-extinction * v.length_m / kReference_m);
      // The integral of V(s) H / reference over the voxel; V(s) = visibility * exp(-extinction s /
      // reference).
      sum += visibility * entropy_(p) * (1.0 - passed) / extinction;
      visibility *= passed;
      if (visibility < kNegligibleVisibility) break;
    }
    return sum;
  }

 private:
  const EntropyTable& entropy_;
};

}  // namespace

GainEntry OcclusionAwareNormalisedGain() {
  return {"occlusion_aware_normalised", "occlusion aware per metre; confirmed free counts as certain",
          GainLaws{.independent_of_voxel_size = true}, GainReads{}, BuildGain<OcclusionAwareNormalised>};
}

}  // namespace atlas::planner
