#include "mapping/cloud/undistort.h"

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

}  // namespace atlas::mapping
