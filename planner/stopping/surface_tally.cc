#include "planner/stopping/surface_tally.h"

#include <algorithm>
#include <cmath>

namespace atlas::planner {
namespace {

/// A floor's own returns scatter about it by less; what hangs lower under a floor belongs to the room below.
constexpr double kGroundBandVoxels = 2.0;

}  // namespace

SurfaceTally::SurfaceTally(const core::Box3& object_box, double voxel_m)
    : box_(object_box), voxel_m_(voxel_m) {
  size_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    size_[axis] = static_cast<int>(std::ceil(box_.Size()[axis] / voxel_m)) + 3;  // a rim of one
    count *= static_cast<size_t>(size_[axis]);
  }
  seen_.assign(count, false);
}

size_t SurfaceTally::IndexOf(const int cell[3]) const {
  return static_cast<size_t>(cell[0]) +
         static_cast<size_t>(size_[0]) *
             (static_cast<size_t>(cell[1]) + static_cast<size_t>(size_[1]) * static_cast<size_t>(cell[2]));
}

bool SurfaceTally::SeenAround(size_t index) const {
  const auto row = static_cast<size_t>(size_[0]), layer = row * static_cast<size_t>(size_[1]);
  const size_t first = index - 1 - row - layer;
  for (size_t k = 0; k < 27; ++k) {
    if (seen_[first + k % 3 + row * (k / 3 % 3) + layer * (k / 9)]) return true;
  }
  return false;
}

namespace {

/// Of the floors above one another, the highest that is above the point by at most `reach_m`; the lowest
/// where none is.
double GroundUnder(const core::Vec3& p, const mapping::TraversableGround& ground, double reach_m) {
  const auto levels = ground.LevelsAt(p.head<2>());
  if (levels.empty()) return ground.SurfaceAt(p).height_m;
  double under = *std::min_element(levels.begin(), levels.end());
  for (const double height : levels) {
    if (height <= p.z() + reach_m) under = std::max(under, height);
  }
  return ground.SurfaceAt({p.x(), p.y(), under}).height_m;
}

}  // namespace

size_t SurfaceTally::CountNew(const std::vector<core::Vec3f>& returns_map,
                              const mapping::TraversableGround& ground) {
  const double band_m = kGroundBandVoxels * voxel_m_;
  std::vector<size_t> unseen;
  for (const core::Vec3f& point : returns_map) {
    const core::Vec3 p = point.cast<double>();
    if (!box_.Contains(p)) continue;
    int cell[3];
    for (int axis = 0; axis < 3; ++axis) {
      cell[axis] = static_cast<int>((p[axis] - box_.min[axis]) / voxel_m_) + 1;
    }
    const size_t index = IndexOf(cell);
    if (seen_[index] || p.z() < GroundUnder(p, ground, band_m) + band_m) continue;
    unseen.push_back(index);
  }
  std::sort(unseen.begin(), unseen.end());
  unseen.erase(std::unique(unseen.begin(), unseen.end()), unseen.end());
  const auto fresh =
      std::count_if(unseen.begin(), unseen.end(), [this](size_t index) { return !SeenAround(index); });
  for (const size_t index : unseen) seen_[index] = true;
  return static_cast<size_t>(fresh);
}

}  // namespace atlas::planner
