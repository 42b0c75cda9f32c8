// How much of a scan a submap has seen already: Cloud Overlap Estimate (thesis 4.7.3, Algorithm 1).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

/// One point a cell of side r_filter, with a neighbour search as far as that needs. Cells lie in bricks of
/// four a side, which know by a bit each which of them hold a point.
class OverlapCloud {
 public:
  /// @pre filter_m > 0
  explicit OverlapCloud(double filter_m) : filter_m_(static_cast<float>(filter_m)), slots_(16, 0) {}

  /// Keeps the first point of each cell. @pre |p| < 2^20 cells.
  void Add(std::span<const core::Vec3f> points);
  /// R_point,read: the share of `points` nearer than sqrt(3) r_filter to one that is kept; 0 for none, and 0
  /// as soon as it cannot come out above `above`.
  double ShareNear(std::span<const core::Vec3f> points, double above = -1.0) const;
  size_t size() const { return size_; }
  /// All that are kept, by cell.
  std::vector<core::Vec3f> Points() const;
  size_t Bytes() const {
    return size_ * sizeof(core::Vec3f) + bricks_.size() * sizeof(Brick) + slots_.size() * sizeof(uint32_t);
  }

 private:
  struct Brick {
    std::array<int, 3> at = {0, 0, 0};  ///< in bricks
    uint64_t held = 0;                  ///< a bit a cell, x fastest
    std::vector<core::Vec3f> points;    ///< by bit
  };
  /// The bricks that the 5 x 5 x 5 cells about a cell lie in: two a side.
  struct Neighbourhood {
    std::array<int, 3> first = {0, 0, 0};  ///< in bricks
    std::array<const Brick*, 8> bricks = {};
    bool asked = false;
  };
  const Brick* Find(const std::array<int, 3>& at) const;
  Brick* FindOrCreate(const std::array<int, 3>& at);
  void Grow();
  bool HasNear(const core::Vec3f& p, Neighbourhood* around) const;

  float filter_m_;
  size_t size_ = 0;
  std::vector<Brick> bricks_;
  std::vector<uint32_t> slots_;  ///< open addressing, a power of two: 1 + a brick's place, or 0
};

/// The points of `points` that are the first in their cells of side `filter_m`.
std::vector<core::Vec3f> FilterCloud(std::span<const core::Vec3f> points, double filter_m);

}  // namespace atlas::mapping
