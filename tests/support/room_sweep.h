// Revolutions in an empty room, and maps of it.
#pragma once

#include <cmath>
#include <memory>
#include <utility>

#include "core/rng.h"
#include "mapping/backends/catalog.h"
#include "tests/support/placed_spins.h"

namespace atlas::tests {

inline const core::Box3 kSweptBox{core::Vec3(-2.3, -2.3, -0.2), core::Vec3(2.3, 2.3, 2.6)};
inline const core::Box3 kSweptRegion = mapping::RegionOf(mapping::MapperParams{}, kSweptBox);

/// Spins in a 4 x 4 x 2.4 m room from the inside: distance to the walls in closed form, every tenth ray void.
inline PlacedSpins RoomSweep(int spins, double noise,
                             const core::Vec3& velocity = core::Vec3(0.5, 0.2, 0.0)) {
  PlacedSpins sweep;
  core::Rng rng(3);
  const core::Box3 room{core::Vec3(-2, -2, 0), core::Vec3(2, 2, 2.4)};
  for (int s = 0; s < spins; ++s) {
    core::SpinEvent event;
    core::LidarScan& scan = event.scan;
    scan.rows = 16;
    scan.columns = 120;
    scan.stamp_s = 0.1 * s;
    const core::Vec3 start(0.3, -0.2, 0.92);
    for (double t = 0.0; t <= 0.1001; t += 0.01) {
      event.T_odom_lidar.Add(scan.stamp_s + t,
                             core::PoseFromXyzYaw(start + (scan.stamp_s + t) * velocity, 0.0));
    }
    for (int row = 0; row < scan.rows; ++row) {
      for (int column = 0; column < scan.columns; ++column) {
        const double azimuth = -2.0 * core::kPi * column / scan.columns,
                     elevation = core::Radians(-40 + 5 * row);
        const double time = 0.1 * column / scan.columns;
        const core::Vec3 direction(std::cos(elevation) * std::cos(azimuth),
                                   std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
        const core::Vec3 origin = start + (scan.stamp_s + time) * velocity;
        const double range = room.Clip(origin, direction)->second + noise * rng.Normal();
        const bool is_void = row == 15;
        scan.direction_lidar.push_back(direction.cast<float>());
        scan.time_s.push_back(static_cast<float>(time));
        scan.range_m.push_back(is_void ? 0.0f : static_cast<float>(range));
        scan.kind.push_back(is_void ? core::ReturnKind::kVoid : core::ReturnKind::kHit);
      }
    }
    sweep.spins.push_back(std::move(event));
  }
  sweep.T_map_odom = core::PoseFromXyzYaw(core::Vec3(0.1, 0.05, 0.0), 0.1);
  return sweep;
}

inline std::unique_ptr<mapping::Map> MapOf(const mapping::MapperParams& params, const core::Box3& box) {
  return mapping::MakeMap(params, {.keep_map = mapping::RegionOf(params, box)});
}

inline mapping::MapperParams OctomapParams() {
  mapping::MapperParams params;
  params.name = "octomap";
  return params;
}

}  // namespace atlas::tests
