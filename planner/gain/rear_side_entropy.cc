// Rear side entropy (Isler 2016; thesis Eq. 3.6): occlusion aware information of the contiguous unknown run
// just before an occupied end. A plain front hit, whose preceding voxel is free, adds nothing.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

class RearSideEntropy final : public RaySumGain {
 public:
  explicit RearSideEntropy(double) : entropy_(EntropyTable::Instance()) {}

  double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd end) const override {
    if (end != mapping::RayEnd::kOccupied) return 0.0;
    const size_t hit = samples.size() - 1;
    size_t first = hit;
    while (first > 0 && IsUnknown(samples[first - 1])) --first;
    if (first == hit) return 0.0;
    double visibility = 1.0, sum = 0.0;
    for (size_t i = 0; i < hit && visibility >= kNegligibleVisibility; ++i) {
      const Attenuation voxels = AttenuationOf(samples[i]);
      if (i >= first) sum += visibility * voxels.visibility * entropy_(samples[i].occupancy);  // Eq. 3.6
      visibility *= voxels.passed;                                                             // Eq. 3.5
    }
    return sum;
  }

 private:
  const EntropyTable& entropy_;
};

}  // namespace

GainEntry RearSideEntropyGain() {
  return {"rear_side_entropy",
          "occlusion aware over the unknown run just before an occupied end (Isler 2016; thesis Eq. 3.6)",
          GainLaws{.at_most_occlusion_aware = true}, GainReads{.each_free = true},
          BuildGain<RearSideEntropy>};
}

}  // namespace atlas::planner
