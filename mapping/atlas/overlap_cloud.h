// How much of a scan a submap has seen already: Cloud Overlap Estimate (thesis 4.7.3, Algorithm 1).
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/geometry.h"

namespace atlas::mapping {

/// One point a cell of side r_filter, with a neighbour search as far as that needs.
class OverlapCloud {
 public:
  /// @pre filter_m > 0
  explicit OverlapCloud(double filter_m) : filter_m_(static_cast<float>(filter_m)) {}

  /// Keeps the first point of each cell. @pre |p| < 2^20 cells.
  void Add(std::span<const core::Vec3f> points);
  /// R_point,read: the share of `points` nearer than sqrt(3) r_filter to one that is kept; 0 for none.
  double ShareNear(std::span<const core::Vec3f> points) const;
  size_t size() const { return cells_.size(); }
  /// All that are kept, by cell.
  std::vector<core::Vec3f> Points() const;
  size_t Bytes() const {
    return cells_.size() * (sizeof(uint64_t) + sizeof(core::Vec3f) + 2 * sizeof(void*));
  }

 private:
  bool HasNear(const core::Vec3f& p) const;

  float filter_m_;
  std::unordered_map<uint64_t, core::Vec3f> cells_;
};

/// The points of `points` that are the first in their cells of side `filter_m`.
std::vector<core::Vec3f> FilterCloud(std::span<const core::Vec3f> points, double filter_m);

}  // namespace atlas::mapping
