// A small dense occupancy map for tests, traced by sorting plane crossings: slow, plain, and unlike any DDA.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "mapping/map_view.h"

namespace atlas::tests {

class VoxelWorld : public mapping::MapView {
 public:
  /// All unknown. @pre the region's sides are whole multiples of the resolution.
  VoxelWorld(const core::Box3& region, double resolution_m) : region_(region), resolution_m_(resolution_m) {
    for (int axis = 0; axis < 3; ++axis)
      size_[axis] = static_cast<int>(std::lround(region.Size()[axis] / resolution_m));
    p_.assign(static_cast<size_t>(size_[0]) * static_cast<size_t>(size_[1]) * static_cast<size_t>(size_[2]),
              0.5f);
  }

  /// Sets every voxel's occupancy from its centre.
  void Fill(const std::function<float(const core::Vec3&)>& occupancy) {
    for (size_t i = 0; i < p_.size(); ++i) p_[i] = occupancy(CenterOf(i));
  }
  void Set(const core::Vec3& p_map, float occupancy) { p_[static_cast<size_t>(IndexAt(p_map))] = occupancy; }

  double resolution_m() const override { return resolution_m_; }
  const core::Box3& region() const { return region_; }
  mapping::CellState StateAt(const core::Vec3& p_map) const override {
    const long i = IndexAt(p_map);
    if (i < 0) return mapping::CellState::kUnknown;
    const double p = static_cast<double>(p_[static_cast<size_t>(i)]);
    if (p > mapping::kOccupiedProbability) return mapping::CellState::kOccupied;
    return p < mapping::kFreeProbability ? mapping::CellState::kFree : mapping::CellState::kUnknown;
  }

  /// Every voxel by itself, whatever the limits allow to be joined.
  mapping::RayEnd Trace(const core::Vec3& origin, const core::Vec3& direction,
                        const mapping::TraceLimits& limits,
                        std::vector<mapping::RaySample>* samples) const override {
    samples->clear();
    const auto inside = region_.Clip(origin, direction), wanted = limits.box_map.Clip(origin, direction);
    if (!inside || !wanted) return mapping::RayEnd::kVoid;
    const double begin = std::max(inside->first, wanted->first),
                 end = std::min({inside->second, wanted->second, limits.max_range_m});
    if (begin >= end) return mapping::RayEnd::kVoid;
    std::vector<double> cuts = {begin, end};
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(direction[axis]) < 1e-12) continue;
      for (int plane = 0; plane <= size_[axis]; ++plane) {
        const double t = (region_.min[axis] + plane * resolution_m_ - origin[axis]) / direction[axis];
        if (t > begin && t < end) cuts.push_back(t);
      }
    }
    std::sort(cuts.begin(), cuts.end());
    for (size_t i = 0; i + 1 < cuts.size(); ++i) {
      if (cuts[i + 1] - cuts[i] < 1e-9) continue;
      const long index = IndexAt(origin + 0.5 * (cuts[i] + cuts[i + 1]) * direction);
      if (index < 0) continue;
      const float p = p_[static_cast<size_t>(index)];
      samples->push_back(
          {p, static_cast<float>(cuts[i + 1] - cuts[i]), static_cast<uint64_t>(index) + 1, 0.0f});
      if (static_cast<double>(p) > mapping::kOccupiedProbability) return mapping::RayEnd::kOccupied;
    }
    return mapping::RayEnd::kVoid;
  }

  void ForEachOccupied(const core::Box3& box_map, const VisitCenter& visit) const override {
    for (size_t i = 0; i < p_.size(); ++i) {
      const core::Vec3 center = CenterOf(i);
      if (static_cast<double>(p_[i]) > mapping::kOccupiedProbability && box_map.Contains(center))
        visit(center.cast<float>());
    }
  }

 private:
  long IndexAt(const core::Vec3& p) const {
    long index[3];
    for (int axis = 0; axis < 3; ++axis) {
      index[axis] = static_cast<long>(std::floor((p[axis] - region_.min[axis]) / resolution_m_));
      if (index[axis] < 0 || index[axis] >= size_[axis]) return -1;
    }
    return index[0] + size_[0] * (index[1] + static_cast<long>(size_[1]) * index[2]);
  }
  core::Vec3 CenterOf(size_t i) const {
    const auto n = static_cast<long>(i);
    const core::Vec3 cell(static_cast<double>(n % size_[0]), static_cast<double>(n / size_[0] % size_[1]),
                          static_cast<double>(n / (static_cast<long>(size_[0]) * size_[1])));
    return region_.min + resolution_m_ * (cell + core::Vec3::Constant(0.5));
  }

  core::Box3 region_;
  double resolution_m_;
  int size_[3];
  std::vector<float> p_;
};

}  // namespace atlas::tests
