// How fast the raycaster is beside Embree alone, for `atlas bench lidar`.
#pragma once

#include "core/lidar_model.h"
#include "scenes/scene_spec.h"

namespace atlas::sim {

/// Rays a second of one thread's CPU time, on revolutions of a rolled LiDAR taken around the scene's object.
struct RaycasterSpeed {
  double rays_per_second = 0.0;             ///< Raycaster::Cast against the scene
  double rays_per_second_with_robot = 0.0;  ///< the same with a robot of 17 bodies about the sensor
  double bare_rays_per_second = 0.0;        ///< the same rays through Embree, packed beforehand
  double spin_ms = 0.0;                     ///< CPU time of one Lidar::Spin, robot and noise included
  size_t triangles = 0;
};

/// Each figure is measured for about `seconds`. Embree alone is given its fastest entry point of packets,
/// single rays and streams.
RaycasterSpeed MeasureRaycaster(const scenes::SceneSpec& scene, const core::LidarModel& lidar,
                                double seconds);

}  // namespace atlas::sim
