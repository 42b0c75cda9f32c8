// Area factor (Vasquez-Gomez 2014): shares of the view that show known surface, occlusion planes and
// unobserved space; best with a fifth of overlap and four fifths of occlusion plane.
#include "planner/gain/area_factor.h"

#include <algorithm>

#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {

double AreaFactorShape(double x, double a) {
  if (x <= a) return x * x * (3.0 * a - 2.0 * x) / (a * a * a);
  const double d = a - 1.0;
  return (-2.0 * x * x * x + 3.0 * (a + 1.0) * x * x - 6.0 * a * x + 3.0 * a - 1.0) / (d * d * d);
}

namespace {

constexpr double kWantedOccupied = 0.2, kWantedOccplane = 0.8;

class AreaFactor final : public Gain {
 public:
  explicit AreaFactor(double) {}

  void BeginView() override { occupied_ = occplane_ = all_ = 0.0; }

  /// A ray's label is that of the first voxel on it that is not free: occupied; an occlusion plane where
  /// unknown begins behind free; else unobserved, as is a ray that meets nothing.
  void AddRay(std::span<const mapping::RaySample> samples, mapping::RayEnd, double weight) override {
    all_ += weight;
    size_t i = 0;
    while (i < samples.size() && IsFree(samples[i])) ++i;
    if (i == samples.size()) return;
    if (IsOccupied(samples[i])) {
      occupied_ += weight;
    } else if (i > 0) {
      occplane_ += weight;
    }
  }

  double FinishView() override {
    if (all_ <= 0.0) return 0.0;
    return std::max(0.0, AreaFactorShape(occupied_ / all_, kWantedOccupied) +
                             AreaFactorShape(occplane_ / all_, kWantedOccplane));
  }

 private:
  double occupied_ = 0.0, occplane_ = 0.0, all_ = 0.0;
};

}  // namespace

GainEntry AreaFactorGain() {
  return {"area_factor", "shares of known surface and occlusion plane in the view (Vasquez-Gomez 2014)",
          GainLaws{.zero_on_certain_rays = false}, GainReads{}, BuildGain<AreaFactor>};
}

}  // namespace atlas::planner
