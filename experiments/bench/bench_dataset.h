// Scans that a mapper is measured on, and the truth they were cast from.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "core/lidar_model.h"
#include "core/sensor_events.h"
#include "scenes/scene_spec.h"

namespace atlas::experiments {

/// Poses are true: T_odom_lidar of the spins is T_map_lidar.
struct BenchDataset {
  std::string name;
  scenes::SceneSpec scene;
  core::LidarModel lidar;
  std::vector<core::SpinEvent> spins;
};

/// Records the scene's own route with an OS1-64 (thesis 4.10), noise on, in memory; `max_scans` of it spread
/// over the first part of the route in order, 0 for all. Repeats exactly.
/// @throws InputError for a scene without a route.
BenchDataset RecordBenchDataset(const std::string& scene, int max_scans, int threads,
                                const std::function<void(double)>& progress);

}  // namespace atlas::experiments
