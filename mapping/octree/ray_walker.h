// A ray through an octree, a stored cell (or a whole uniform node) a step.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "mapping/octree/octree.h"

namespace atlas::mapping {

/// A stretch of a ray inside one cell that holds one value: a voxel, a coarse cell, or a node (up to a whole
/// chunk) whose blocks are uniform and equal.
template <typename Field>
struct RaySegment {
  typename Field::Value value;
  double t_begin_m = 0.0, t_end_m = 0.0;
  int level = 0;  ///< of the cell: 0 voxel, 1 coarse cell, 3 block ... 6 chunk
};

/// Steps from cell to cell. Each step leaves through a face of the current cell, and the next voxel is
/// clamped to that face, so that rounding never skips or repeats a cell.
template <typename Field>
class RayWalker {
 public:
  using Chunk = typename Octree<Field>::Chunk;

  /// @pre direction is unit.
  RayWalker(const Octree<Field>& map, const core::Vec3& origin, const core::Vec3& direction,
            double max_range_m)
      : map_(&map), range_m_(max_range_m), voxel_(map.KeyAt(origin)) {
    for (int a = 0; a < 3; ++a) {
      origin_[a] = origin[a] / map.resolution_m();
      slope_[a] = direction[a] / map.resolution_m();
      t_per_voxel_[a] =
          direction[a] == 0.0 ? std::numeric_limits<double>::infinity() : map.resolution_m() / direction[a];
    }
  }

  bool done() const { return t_ >= range_m_; }
  double t() const { return t_; }
  const NodeKey& voxel() const { return voxel_; }
  /// The chunk of the current voxel, or null where there is none.
  const Chunk* chunk() {
    const NodeKey key = voxel_.Up(kChunkLevel);
    if (!looked_up_ || !(key == chunk_key_)) {
      chunk_ = map_->Find(key);
      chunk_key_ = key;
      looked_up_ = true;
    }
    return chunk_;
  }

  /// Leaves the current voxel's ancestor at `level` and returns where, at most at the end of the ray.
  double Leave(int level) {
    int32_t* const voxel[3] = {&voxel_.x, &voxel_.y, &voxel_.z};
    int32_t lo[3];
    double t_leave = std::numeric_limits<double>::infinity();
    int axis = 0;
    for (int a = 0; a < 3; ++a) {
      lo[a] = *voxel[a] >> level << level;
      if (slope_[a] == 0.0) continue;
      const double face = slope_[a] > 0.0 ? lo[a] + (1 << level) : lo[a];
      const double t_face = (face - origin_[a]) * t_per_voxel_[a];
      if (t_face < t_leave) {
        t_leave = t_face;
        axis = a;
      }
    }
    t_ = std::max(t_, t_leave);
    if (t_ >= range_m_) return t_ = range_m_;
    const int32_t side = 1 << level;
    for (int a = 0; a < 3; ++a) {
      if (a == axis) {
        *voxel[a] = slope_[a] > 0.0 ? lo[a] + side : lo[a] - 1;
      } else if (slope_[a] != 0.0) {
        const auto at = static_cast<int32_t>(std::floor(origin_[a] + t_ * slope_[a]));
        // Never backwards: rounding may not undo a step.
        const int32_t first = slope_[a] > 0.0 ? *voxel[a] : lo[a];
        const int32_t last = slope_[a] > 0.0 ? lo[a] + side - 1 : *voxel[a];
        *voxel[a] = std::clamp(at, first, last);
      }
    }
    return t_;
  }

 private:
  const Octree<Field>* map_;
  double range_m_, t_ = 0.0;
  NodeKey voxel_, chunk_key_;
  const Chunk* chunk_ = nullptr;
  bool looked_up_ = false;
  double origin_[3], slope_[3], t_per_voxel_[3];  ///< in voxels; metres of ray a voxel, signed
};

/// The level of the largest node of uniform, equal blocks around a uniform block: 3 to 6.
template <typename Field>
int UniformLevel(const typename Octree<Field>::Chunk& chunk, int block) {
  const auto uniform_and_equal = [&](int first, int count) {
    for (int word = first >> 6; word <= (first + count - 1) >> 6; ++word) {
      const uint64_t bits = count >= 64 ? ~uint64_t{0} : ((uint64_t{1} << count) - 1) << (first & 63);
      const auto w = static_cast<size_t>(word);
      if ((chunk.fine.bits[w] | chunk.coarse.bits[w]) & bits) return false;
    }
    if constexpr (std::is_same_v<Field, OccupancyField>) {
      const int8_t* const values = chunk.uniform.log_odds + first;
      return std::memcmp(values, values + 1, static_cast<size_t>(count - 1)) == 0;
    } else {
      for (int b = first + 1; b < first + count; ++b) {
        if (!(chunk.uniform.Get(b) == chunk.uniform.Get(first))) return false;
      }
      return true;
    }
  };
  int level = kBlockLevel;
  while (level < kChunkLevel) {
    const int count = 1 << 3 * (level + 1 - kBlockLevel);
    if (!uniform_and_equal(block & ~(count - 1), count)) break;
    ++level;
  }
  return level;
}

}  // namespace atlas::mapping
