// Revolutions placed by hand.
#pragma once

#include <memory>
#include <vector>

#include "core/keyframe.h"
#include "mapping/cloud/scan_cloud.h"
#include "mapping/map.h"
#include "mapping/slam/fixed_poses.h"

namespace atlas::tests {

inline std::shared_ptr<const core::SpinEvent> Shared(core::SpinEvent spin) {
  return std::make_shared<const core::SpinEvent>(std::move(spin));
}

/// The revolutions of one scanning action, all under one pose of the odometry's frame.
struct PlacedSpins {
  std::vector<core::SpinEvent> spins;
  core::Pose T_map_odom = core::Pose::Identity();
};

inline void Integrate(const core::SpinEvent& spin, const core::Pose& T_map_odom, mapping::Map* map) {
  map->Integrate({.spin = Shared(spin)}, mapping::FixedPoses({T_map_odom}));
}
inline void Integrate(const PlacedSpins& sweep, mapping::Map* map) {
  for (const core::SpinEvent& spin : sweep.spins) Integrate(spin, sweep.T_map_odom, map);
}

/// The cloud of all of them.
inline mapping::ReturnCloud CloudOf(const PlacedSpins& sweep, const core::Box3& box_map, double max_range_m,
                                    double spacing_m) {
  mapping::ScanCloud scan(box_map, max_range_m, spacing_m);
  mapping::ReturnCloud cloud;
  for (const core::SpinEvent& spin : sweep.spins) {
    const mapping::ReturnCloud more = scan.Add(spin, sweep.T_map_odom);
    cloud.points.insert(cloud.points.end(), more.points.begin(), more.points.end());
    cloud.origins.insert(cloud.origins.end(), more.origins.begin(), more.origins.end());
  }
  return cloud;
}

}  // namespace atlas::tests
