#include "mapping/cloud/scan_cloud.h"

namespace atlas::mapping {

ScanCloud::ScanCloud(const core::Box3& box_map, double max_range_m, double spacing_m)
    : min_(box_map.min.cast<float>()),
      max_(box_map.max.cast<float>()),
      max_range_m_(static_cast<float>(max_range_m)),
      spacing_m_(spacing_m),
      filter_(spacing_m) {}

ReturnCloud ScanCloud::Add(const core::SpinEvent& spin, const core::Pose& T_map_odom) {
  UndistortHits(spin, T_map_odom, &undistorted_);
  ReturnCloud cloud;
  for (const MapRay& ray : undistorted_.hits) {
    if (ray.range_m > max_range_m_) continue;
    const core::Vec3f p = ray.origin_map + ray.range_m * ray.direction_map;
    if ((p.array() < min_.array()).any() || (p.array() > max_.array()).any()) continue;
    if (filter_.Insert(p)) cloud.Add(p, ray.origin_map);
  }
  return cloud;
}

}  // namespace atlas::mapping
