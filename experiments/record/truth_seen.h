// Which of a scene's surfaces a recorded sensor could have met at all.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry.h"
#include "core/lidar_model.h"
#include "core/sensor_events.h"
#include "sim/sensors/raycaster.h"

namespace atlas::experiments {

/// 1 for each point (with its outward normal) that some pose sees: within the LiDAR's range and vertical
/// field of view, from before the surface, and with nothing in between. Of the poses that qualify but for
/// what is in between, the nearest eight are tried. Results do not depend on `threads`.
std::vector<uint8_t> SeenPoints(std::span<const core::Vec3f> points, std::span<const core::Vec3f> normals,
                                const std::vector<core::StampedPose>& T_map_lidar,
                                const core::LidarModel& lidar, const sim::Raycaster& raycaster, int threads);

}  // namespace atlas::experiments
