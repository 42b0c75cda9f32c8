// One point a cell of a grid.
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

/// Keeps the first point in each cell of a grid; remembers cells across calls.
class VoxelFilter {
 public:
  explicit VoxelFilter(double cell_m) : inverse_cell_(1.0 / cell_m), table_(1u << 16, kEmpty) {}
  /// Whether `p` is the first in its cell. @pre |p| < 2^20 cells.
  bool Insert(const core::Vec3f& p);

 private:
  static constexpr uint64_t kEmpty = ~uint64_t{0};
  void Grow();
  double inverse_cell_;
  std::vector<uint64_t> table_;  // open addressing, power of two
  size_t size_ = 0;
};

}  // namespace atlas::mapping
