// From voxel to voxel along a line.
#pragma once

#include <cmath>
#include <limits>

#include "mapping/octree/morton.h"

namespace atlas::mapping {

/// Steps through the voxels that a line crosses (Amanatides and Woo), in coordinates of one unit a voxel.
template <typename Real>
class VoxelWalk {
 public:
  /// @pre `start` holds `p`.
  VoxelWalk(const Real p[3], const Real direction[3], const NodeKey& start) : voxel_(start) {
    const int32_t cell[3] = {start.x, start.y, start.z};
    for (int i = 0; i < 3; ++i) {
      const bool moves = std::abs(direction[i]) > Real(1e-9);
      const bool up = direction[i] > 0;
      step_[i] = up ? 1 : -1;
      per_voxel_[i] = moves ? 1 / std::abs(direction[i]) : std::numeric_limits<Real>::max();
      const Real inside = p[i] - static_cast<Real>(cell[i]);
      next_[i] = moves ? (up ? 1 - inside : inside) * per_voxel_[i] : std::numeric_limits<Real>::max();
    }
  }

  const NodeKey& voxel() const { return voxel_; }
  const NodeKey& Next() {
    if (next_[0] < next_[1] && next_[0] < next_[2]) {
      voxel_.x += step_[0];
      next_[0] += per_voxel_[0];
    } else if (next_[1] < next_[2]) {
      voxel_.y += step_[1];
      next_[1] += per_voxel_[1];
    } else {
      voxel_.z += step_[2];
      next_[2] += per_voxel_[2];
    }
    return voxel_;
  }

 private:
  NodeKey voxel_;
  int32_t step_[3];
  Real per_voxel_[3], next_[3];
};

}  // namespace atlas::mapping
