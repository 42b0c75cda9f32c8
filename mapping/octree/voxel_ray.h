// A ray through the voxels of an octree, voxel by voxel or an aligned cube at a time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "mapping/octree/morton.h"

namespace atlas::mapping {

/// Voxels from `first` to `last`, both inside.
struct VoxelRange {
  NodeKey first, last;
};
/// Of the voxels that meet the inside of a box; of what an octree can hold where it is unbounded.
inline VoxelRange VoxelsOf(const core::Box3& box, double resolution_m) {
  const auto bound = [&](double metres, bool up) {
    const double voxels =
        std::clamp(metres / resolution_m, -static_cast<double>(kKeyLimit), static_cast<double>(kKeyLimit));
    return static_cast<int32_t>(up ? std::ceil(voxels - 1e-6) - 1.0 : std::floor(voxels + 1e-6));
  };
  return {{bound(box.min.x(), false), bound(box.min.y(), false), bound(box.min.z(), false)},
          {bound(box.max.x(), true), bound(box.max.y(), true), bound(box.max.z(), true)}};
}

/// An incremental traversal (Amanatides and Woo 1987), whose steps may be as long as what holds one value:
///
///     +---+---+-------+          voxels one by one where they differ,
///     | . | .'|       |
///     +---+'--+   .-'''-->       the cube in one step where they do not: as many voxels,
///     |.' |   |.-'    |          and as long, as the steps through them would have told
///     +---+---+-------+
class VoxelRay {
 public:
  /// From t_begin to t_end, metres along the ray; the first voxel is clamped to `within`, so that rounding at
  /// a face adds none. @pre direction is unit, t_begin < t_end.
  VoxelRay(const core::Vec3& origin, const core::Vec3& direction, double resolution_m, double t_begin,
           double t_end, const VoxelRange& within)
      : t_(t_begin), t_end_(t_end), t_last_(t_end - 1e-9) {
    const core::Vec3 local = (origin + t_begin * direction) / resolution_m;
    const int32_t first[3] = {within.first.x, within.first.y, within.first.z};
    const int32_t last[3] = {within.last.x, within.last.y, within.last.z};
    for (int a = 0; a < 3; ++a) {
      key_[a] = std::clamp(static_cast<int32_t>(std::floor(local[a])), first[a], last[a]);
      step_[a] = direction[a] > 0.0 ? 1 : -1;
      if (direction[a] == 0.0) {
        t_next_[a] = t_delta_[a] = std::numeric_limits<double>::infinity();
        per_delta_[a] = 0.0;
        continue;
      }
      const double face = resolution_m * (key_[a] + (step_[a] > 0 ? 1 : 0));
      t_next_[a] = (face - origin[a]) / direction[a];
      t_delta_[a] = resolution_m / std::abs(direction[a]);
      per_delta_[a] = 1.0 / t_delta_[a];
    }
  }

  NodeKey voxel() const { return {key_[0], key_[1], key_[2]}; }

  /// Calls `visit(index, length_m)`, index in the block, on each voxel up to the end of the current block.
  /// Returns false when the ray ends or `visit` returns false, which `stopped` then tells.
  template <typename Visit>
  bool CrossVoxels(bool* stopped, const Visit& visit) {
    int left[3], index = VoxelIndex(key_[0], key_[1], key_[2]), axis = 0;
    const int jump[3] = {step_[0], step_[1] * 8, step_[2] * 64};
    for (int a = 0; a < 3; ++a) left[a] = StepsLeft(a, kBlockLevel);
    // Which face comes next is as good as random: selects, not branches.
    do {
      const bool x_first = (t_next_[0] <= t_next_[1]) & (t_next_[0] <= t_next_[2]);
      axis = x_first ? 0 : (t_next_[1] <= t_next_[2] ? 1 : 2);
      const double t_leave = t_next_[axis];
      const bool last = t_leave >= t_last_;
      if (!visit(index, (last ? t_end_ : t_leave) - t_)) {
        *stopped = true;
        return false;
      }
      if (last) return false;
      t_ = t_leave;
      key_[axis] += step_[axis];
      index += jump[axis];
      t_next_[axis] += t_delta_[axis];
    } while (--left[axis] > 0);
    return true;
  }

  /// Crosses the rest of the aligned cube of 2^level voxels a side at once: adds to the voxels met and their
  /// length. Returns false when the ray ends.
  bool CrossCube(int level, uint32_t* voxels, float* length_m) {
    int left[3], axis = 0;
    double t_exit = std::numeric_limits<double>::infinity();
    for (int a = 0; a < 3; ++a) {
      left[a] = StepsLeft(a, level);
      const double t = t_next_[a] + (left[a] - 1) * t_delta_[a];
      if (t < t_exit) {
        t_exit = t;
        axis = a;
      }
    }
    const bool last = t_exit >= t_last_;
    const double t_leave = last ? t_end_ : t_exit;
    *voxels += 1;
    for (int a = 0; a < 3; ++a) {
      // Faces before the end; ties on other axes are left to the next cube.
      int steps = left[a];
      if (a != axis || last) {
        const double ahead = ((last ? t_last_ : t_leave) - t_next_[a]) * per_delta_[a];
        steps = ahead > 0.0 ? std::min(static_cast<int>(ahead) + 1, left[a] - 1) : 0;
      }
      *voxels += static_cast<uint32_t>(steps - (a == axis && !last ? 1 : 0));
      key_[a] += steps * step_[a];
      t_next_[a] += steps > 0 ? steps * t_delta_[a] : 0.0;
    }
    *length_m += static_cast<float>(t_leave - t_);
    t_ = t_leave;
    return !last;
  }

 private:
  /// Along an axis until the ray leaves the aligned cube.
  int StepsLeft(int a, int level) const {
    const int mask = (1 << level) - 1, inside = key_[a] & mask;
    return step_[a] > 0 ? mask + 1 - inside : inside + 1;
  }

  double t_, t_end_, t_last_;
  double t_next_[3], t_delta_[3], per_delta_[3];
  int32_t key_[3];
  int step_[3];
};

}  // namespace atlas::mapping
