#include "mapping/undistort.h"

#include "core/rng.h"
#include "mapping/mapper.h"

namespace atlas::mapping {
namespace {

using core::Pose;
using core::ReturnKind;
using core::Vec3f;

/// T_map_lidar at the time of each column of row 0, which every row shares on a spinning LiDAR.
std::vector<Eigen::Isometry3f> ColumnPoses(const core::SpinEvent& spin, const Pose& T_map_odom) {
  std::vector<Eigen::Isometry3f> poses(static_cast<size_t>(spin.scan.columns));
  for (size_t column = 0; column < poses.size(); ++column) {
    const double time_s = spin.scan.stamp_s + static_cast<double>(spin.scan.time_s[column]);
    poses[column] = (T_map_odom * spin.T_odom_lidar.At(time_s)).cast<float>();
  }
  return poses;
}

/// A return stands alone when no ray within two columns of its row returned at a like range.
bool Isolated(const core::LidarScan& scan, int row, int column) {
  const size_t base = static_cast<size_t>(row) * static_cast<size_t>(scan.columns);
  const float range = scan.range_m[base + static_cast<size_t>(column)];
  const float tolerance = std::max(0.10f, 0.05f * range);
  for (const int offset : {-1, 1, -2, 2}) {
    const int neighbour = (column + offset + scan.columns) % scan.columns;
    const size_t j = base + static_cast<size_t>(neighbour);
    if (scan.kind[j] == ReturnKind::kHit && std::abs(scan.range_m[j] - range) < tolerance) return false;
  }
  return true;
}

template <bool kVoids>
void UndistortInto(const core::SpinEvent& spin, const Pose& T_map_odom, UndistortedSpin* out) {
  out->hits.clear();
  out->voids.clear();
  const core::LidarScan& scan = spin.scan;
  const auto poses = ColumnPoses(spin, T_map_odom);
  for (int row = 0; row < scan.rows; ++row) {
    for (int column = 0; column < scan.columns; ++column) {
      const size_t i =
          static_cast<size_t>(row) * static_cast<size_t>(scan.columns) + static_cast<size_t>(column);
      if (scan.kind[i] == ReturnKind::kDropout) continue;
      const bool hit = scan.kind[i] == ReturnKind::kHit;
      if (!kVoids && !hit) continue;
      if (hit && Isolated(scan, row, column)) continue;
      const auto& T = poses[static_cast<size_t>(column)];
      const Vec3f direction = T.linear() * scan.direction_lidar[i];
      (hit ? out->hits : out->voids).push_back({T.translation(), direction, hit ? scan.range_m[i] : 0.0f});
    }
  }
}

}  // namespace

void Undistort(const core::SpinEvent& spin, const Pose& T_map_odom, UndistortedSpin* out) {
  UndistortInto<true>(spin, T_map_odom, out);
}

void UndistortHits(const core::SpinEvent& spin, const Pose& T_map_odom, UndistortedSpin* out) {
  UndistortInto<false>(spin, T_map_odom, out);
}

bool VoxelFilter::Insert(const Vec3f& p) {
  uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = static_cast<int64_t>(std::floor(static_cast<double>(p[axis]) * inverse_cell_));
    key = (key << 21) | (static_cast<uint64_t>(cell + (1 << 20)) & 0x1fffff);
  }
  if (2 * (size_ + 1) > table_.size()) Grow();
  const size_t mask = table_.size() - 1;
  for (size_t slot = core::HashCounter(0, key) & mask;; slot = (slot + 1) & mask) {
    if (table_[slot] == key) return false;
    if (table_[slot] == kEmpty) {
      table_[slot] = key;
      ++size_;
      return true;
    }
  }
}

void VoxelFilter::Grow() {
  std::vector<uint64_t> old(2 * table_.size(), kEmpty);
  old.swap(table_);
  const size_t mask = table_.size() - 1;
  for (const uint64_t key : old) {
    if (key == kEmpty) continue;
    size_t slot = core::HashCounter(0, key) & mask;
    while (table_[slot] != kEmpty) slot = (slot + 1) & mask;
    table_[slot] = key;
  }
}

ReturnCloud AccumulateSweep(const core::Sweep& sweep, const core::Box3& region_map, double max_range_m,
                            double spacing_m) {
  ReturnCloud cloud;
  VoxelFilter filter(spacing_m);
  UndistortedSpin spin;
  for (const core::SpinEvent& event : sweep.spins) {
    Undistort(event, sweep.T_map_odom, &spin);
    for (const MapRay& ray : spin.hits) {
      if (ray.range_m > static_cast<float>(max_range_m)) continue;
      const Vec3f p = ray.origin_map + ray.range_m * ray.direction_map;
      if (region_map.Contains(p.cast<double>()) && filter.Insert(p)) cloud.Add(p, ray.origin_map);
    }
  }
  return cloud;
}

}  // namespace atlas::mapping
