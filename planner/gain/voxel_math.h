// What several gains ask of one voxel.
#pragma once

#include <array>

#include "mapping/map_view.h"

namespace atlas::planner {

/// What the voxel counts as in its map (mapping::CellState).
inline bool IsUnknown(const mapping::RaySample& v) {
  return v.state == mapping::CellState::kUnknown;
}
inline bool IsFree(const mapping::RaySample& v) {
  return v.state == mapping::CellState::kFree;
}
inline bool IsOccupied(const mapping::RaySample& v) {
  return v.state == mapping::CellState::kOccupied;
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

/// What a sample does to a sum of visibility over the voxels that it stands for (Eq. 3.4, 3.5).
struct Attenuation {
  double passed;      ///< of the visibility in front of the first voxel, what is left behind the last
  double visibility;  ///< summed over the voxels, each in front of its own, of one in front of the first
};
inline Attenuation AttenuationOf(const mapping::RaySample& sample) {
  const double p = sample.occupancy;
  if (sample.voxels == 1) return {1.0 - p, 1.0};
  double passed = 1.0, power = 1.0 - p;
  for (uint32_t n = sample.voxels; n > 0; n >>= 1) {
    if (n & 1) passed *= power;
    power *= power;
  }
  return {passed, p > 0.0 ? (1.0 - passed) / p : static_cast<double>(sample.voxels)};
}

/// Visibility below this cannot change a sum in any digit that matters; the rest of the ray is skipped.
constexpr double kNegligibleVisibility = 1e-9;

}  // namespace atlas::planner
