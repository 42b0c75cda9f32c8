#include "mapping/atlas/overlap_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mapping/cloud/voxel_filter.h"

namespace atlas::mapping {
namespace {

using core::Vec3f;

constexpr int kCellBits = 21, kCellOffset = 1 << 20;

uint64_t CellCode(int x, int y, int z) {
  const auto part = [](int v) { return static_cast<uint64_t>(v + kCellOffset); };
  return part(x) | part(y) << kCellBits | part(z) << 2 * kCellBits;
}

/// Cells within sqrt(3) sides of any point of the one in the middle, nearest first.
std::vector<std::array<int, 3>> NeighbourCells() {
  std::vector<std::array<int, 3>> cells;
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      for (int z = -2; z <= 2; ++z) cells.push_back({x, y, z});
    }
  }
  const auto gap = [](const std::array<int, 3>& c) {
    int sum = 0;
    for (const int v : c) sum += v * v;
    return sum;
  };
  std::stable_sort(cells.begin(), cells.end(), [&](const auto& a, const auto& b) { return gap(a) < gap(b); });
  return cells;
}

}  // namespace

void OverlapCloud::Add(std::span<const Vec3f> points) {
  for (const Vec3f& p : points) {
    const Vec3f cell = (p / filter_m_).array().floor();
    cells_.try_emplace(
        CellCode(static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())), p);
  }
}

bool OverlapCloud::HasNear(const Vec3f& p) const {
  static const std::vector<std::array<int, 3>> kNeighbours = NeighbourCells();
  const Vec3f cell = (p / filter_m_).array().floor();
  const float limit_sq = 3.0f * filter_m_ * filter_m_;
  for (const auto& [x, y, z] : kNeighbours) {
    const auto found = cells_.find(CellCode(static_cast<int>(cell.x()) + x, static_cast<int>(cell.y()) + y,
                                            static_cast<int>(cell.z()) + z));
    if (found != cells_.end() && (found->second - p).squaredNorm() < limit_sq) return true;
  }
  return false;
}

std::vector<Vec3f> OverlapCloud::Points() const {
  std::vector<std::pair<uint64_t, Vec3f>> order(cells_.begin(), cells_.end());
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vec3f> points;
  for (const auto& [cell, p] : order) points.push_back(p);
  return points;
}

double OverlapCloud::ShareNear(std::span<const Vec3f> points) const {
  if (points.empty()) return 0.0;
  size_t near = 0;
  for (const Vec3f& p : points) near += HasNear(p);
  return static_cast<double>(near) / static_cast<double>(points.size());
}

std::vector<Vec3f> FilterCloud(std::span<const Vec3f> points, double filter_m) {
  VoxelFilter filter(filter_m);
  std::vector<Vec3f> kept;
  for (const Vec3f& p : points) {
    if (filter.Insert(p)) kept.push_back(p);
  }
  return kept;
}

}  // namespace atlas::mapping
