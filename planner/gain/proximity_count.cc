// Proximity count (Isler 2016): unmeasured voxels close behind observed surfaces, the closer the more. The
// mapper stores D - delta in them; there is no visibility term.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

class ProximityCount final : public RaySumGain {
 public:
  explicit ProximityCount(double) {}

  double RayValue(std::span<const mapping::RaySample> samples, mapping::RayEnd) const override {
    double sum = 0.0;
    for (const mapping::RaySample& v : samples) {
      if (IsUnknown(v)) sum += v.behind_surface;
    }
    return sum;
  }
};

}  // namespace

GainEntry ProximityCountGain() {
  return {"proximity_count", "unmeasured voxels weighted by closeness behind a surface (Isler 2016)",
          GainLaws{}, GainReads{.behind_surface = true}, BuildGain<ProximityCount>};
}

}  // namespace atlas::planner
