// What several gains ask of one voxel.
#pragma once

#include <array>

#include "mapping/occupancy_view.h"

namespace atlas::planner {

/// Neither free nor occupied (PLANNERS.md: p in [0.2, 0.8]).
inline bool IsUnknown(float p) {
  return p >= static_cast<float>(mapping::kFreeProbability) &&
         p <= static_cast<float>(mapping::kOccupiedProbability);
}
inline bool IsFree(float p) {
  return p < static_cast<float>(mapping::kFreeProbability);
}
inline bool IsOccupied(float p) {
  return p > static_cast<float>(mapping::kOccupiedProbability);
}

/// H(p) by linear interpolation in a table, within 1e-6 of Entropy(p) (thesis Eq. 3.3). A ray of a hundred
/// voxels would otherwise cost two hundred logarithms.
class EntropyTable {
 public:
  static const EntropyTable& Instance();
  double operator()(double p) const {
    if (p < kExactBelow || p > 1.0 - kExactBelow) return Exact(p);
    const double x = p * kCells;
    const auto cell = static_cast<size_t>(x);
    const double u = x - static_cast<double>(cell);
    return value_[cell] + u * (value_[cell + 1] - value_[cell]);
  }

 private:
  EntropyTable();
  static double Exact(double p);
  static constexpr int kCells = 4096;
  static constexpr double kExactBelow = 0.01;
  std::array<double, kCells + 2> value_;
};

/// Visibility below this cannot change a sum in any digit that matters; the rest of the ray is skipped.
constexpr double kNegligibleVisibility = 1e-9;

}  // namespace atlas::planner
