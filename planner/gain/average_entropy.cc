// Average entropy (Kriegel 2015): mean entropy of the voxels on rays that end on a surface, free ones
// included.
#include "planner/gain/entries.h"
#include "planner/gain/voxel_math.h"

namespace atlas::planner {
namespace {

class AverageEntropy final : public Gain {
 public:
  explicit AverageEntropy(double) : entropy_(EntropyTable::Instance()) {}

  void BeginView() override { sum_ = voxels_ = 0.0; }
  void AddRay(std::span<const mapping::RaySample> samples, mapping::RayEnd end, double weight) override {
    if (end != mapping::RayEnd::kOccupied) return;
    double ray = 0.0, voxels = 0.0;
    for (const mapping::RaySample& v : samples) {
      ray += v.voxels * entropy_(v.occupancy);
      voxels += v.voxels;
    }
    sum_ += weight * ray;
    voxels_ += weight * voxels;
  }
  double FinishView() override { return voxels_ > 0.0 ? sum_ / voxels_ : 0.0; }

 private:
  const EntropyTable& entropy_;
  double sum_ = 0.0, voxels_ = 0.0;
};

}  // namespace

GainEntry AverageEntropyGain() {
  return {"average_entropy", "mean entropy of the voxels on rays that end occupied (Kriegel 2015)",
          GainLaws{}, GainReads{.each_free = true}, BuildGain<AverageEntropy>};
}

}  // namespace atlas::planner
